"""What the drawing of a resonator says of its rotor."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from platform_daemon.estimation.thresholds import THRESHOLDS

from .equations import PERMEABILITY

LIMITS = THRESHOLDS.rigid_rotor


@dataclass(frozen=True, kw_only=True)
class RotorGeometry:
    """What the drawing of a resonator says.

    radius_m: of rotor and stator; stator_moment_am2: by design; link_m: length of a thread, or R - r of a jewel's cup;
    friction_coefficient: mu of the jewel's contact by its materials, 0 for a thread; radius_sd_m, link_sd_m: how well
    the drawing is known to hold, 0: it holds.
    """

    bearing: Literal["thread", "jewel"]
    radius_m: float
    mass_kg: float
    stator_moment_am2: float
    link_m: float
    friction_coefficient: float = 0.0
    radius_sd_m: float = 0.0
    link_sd_m: float = 0.0

    @property
    def drawn(self) -> bool:
        """By the resonator's own drawing, which holds."""
        return self.radius_sd_m == 0.0 and self.link_sd_m == 0.0

    def resized(self, radius_off_m: float, link_off_m: float) -> RotorGeometry:
        """The same with a radius and a link that are so much larger, and magnets of the same material."""
        radius_m = self.radius_m + radius_off_m
        larger = (radius_m / self.radius_m) ** 3
        return replace(
            self,
            radius_m=radius_m,
            mass_kg=larger * self.mass_kg,
            stator_moment_am2=larger * self.stator_moment_am2,
            link_m=self.link_m + link_off_m,
        )

    def with_tolerances(self) -> RotorGeometry:
        """The same for a resonator that is only like this one."""
        radius_sd_m, link_sd_m = LIMITS.radius_sd_share * self.radius_m, LIMITS.link_sd_share * self.link_m
        return replace(self, radius_sd_m=radius_sd_m, link_sd_m=link_sd_m)

    @property
    def inertia_kg_m2(self) -> float:
        """Of a homogeneous sphere about a diameter."""
        return 0.4 * self.mass_kg * self.radius_m**2

    def distance_m(self, f_nat_hz: float, m_r_am2: float) -> float:
        """Of the magnets' centres, such that the stator's design moment gives f_nat with m_r (eq:T_m, eq:omega_nat)."""
        field_t = self.inertia_kg_m2 * (2.0 * math.pi * f_nat_hz) ** 2 / m_r_am2
        return float(np.cbrt(PERMEABILITY * self.stator_moment_am2 / field_t))

    def pull_n(self, f_nat_hz: float, distance_m: float) -> float:
        """Attraction of the magnets, undeflected, N (eq:fm(phi))."""
        return 3.0 * self.inertia_kg_m2 * (2.0 * math.pi * f_nat_hz) ** 2 / distance_m

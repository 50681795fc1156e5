"""One-angle fits and rotors as vectors, about a reference orientation.

One angle: f_nat, the losses, phi_max, psi, and turns about u, v, w; m_r scales everything and stands beside them.
Rotor: f_nat, lambda, ln of T_f/I over its reference, ln of drive size times m_r over its reference, the delay of the
samples, and turns; m_r beside them: the motion depends on m_r through the torque of the drive alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.physics.rotation import (
    HALF_TURN_ABOUT_U,
    rodrigues_from_rotation,
    rotation_from_rodrigues,
)
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters

LOSSES = ("lambda_per_s", "tf_over_i_rad_per_s2")
TURNS = 3


@dataclass(frozen=True, eq=False)
class OneAngle:
    """A one-angle motion as it is seen: its vector, and m_r in A m^2."""

    vector: Array
    m_r_am2: float


@dataclass(frozen=True, eq=False)
class OneAngleCoordinates:
    """model: of one angle, with what it knows; rotation: (3, 3) reference; psi_rad: of the start phase, near which all
    are named."""

    model: RingDownModel
    rotation: Array
    psi_rad: float

    @property
    def losses(self) -> tuple[str, ...]:
        """Those of LOSSES that the model has, in this order."""
        return tuple(name for name in LOSSES if name in self.model.losses)

    def of(self, values: Mapping[str, float]) -> OneAngle:
        """Of published parameters; of the twin that faces as the reference does."""
        turned = self.rotation.T @ rotation_from_rodrigues(np.array([values[name] for name in RODRIGUES]))
        psi = values["psi_start_rad"] - self.psi_rad
        if turned[2, 2] < 0.0:
            turned, psi = turned @ HALF_TURN_ABOUT_U, psi + math.pi
        psi = self.psi_rad + (psi + math.pi) % (2.0 * math.pi) - math.pi
        losses = [values[name] for name in self.losses]
        turns = rodrigues_from_rotation(turned)
        vector = np.array([values["f_nat_hz"], *losses, values["phi_max_rad"], psi, *turns])
        return OneAngle(vector, values["m_r_am2"])

    def rotated(self, turns: Array) -> Array:
        """The orientation (3, 3) after turns (3,) about u, v, w."""
        return np.asarray(self.rotation @ rotation_from_rodrigues(turns))

    def dynamics(self, at: OneAngle) -> MotionParameters:
        """Of the motion.  Raises ValueError, LostTrajectoryError where there is none."""
        f_nat_hz, *rest = at.vector[:-TURNS].tolist()
        *losses, phi_max, psi = rest
        values = dict(zip(self.losses, losses, strict=True))
        values |= {name: p.fixed for name, p in self.model.parameters.items() if p.fixed is not None}
        known = {"f_nat_hz": f_nat_hz, "phi_max_rad": phi_max, "psi_start_rad": psi, "m_r_am2": at.m_r_am2}
        return RingDown.from_parameters(self.model, values | known).dynamics


@dataclass(frozen=True, eq=False)
class RotorCoordinates:
    """Of rotors about a reference, whose other parameters they share."""

    reference: RotorValues

    @property
    def jewel(self) -> bool:
        """It has friction."""
        return self.reference.tf_over_i_rad_per_s2 > 0.0

    @property
    def bent(self) -> int:
        """The place of what takes the motion farthest from the reference: friction, or the size of the drive."""
        return 2

    def values(self, vector: Array, m_r_am2: float) -> RotorValues:
        """The rotor of a vector."""
        f_nat_hz, lambda_per_s, *rest = vector.tolist()
        friction = {}
        if self.jewel:
            friction["tf_over_i_rad_per_s2"] = self.reference.tf_over_i_rad_per_s2 * math.exp(rest.pop(0))
        size, delay, *turns = rest
        own = self.reference.m_r_am2
        return self.reference.with_numbers(
            {
                "f_nat_hz": f_nat_hz,
                "lambda_per_s": lambda_per_s,
                **friction,
                "drive_size": self.reference.drive_size * math.exp(size) * own / m_r_am2,
                "drive_delay_s": delay,
                "m_r_am2": m_r_am2,
                **dict(zip(("turn_u_rad", "turn_v_rad", "turn_w_rad"), turns, strict=True)),
            }
        )

    def centre(self) -> Array:
        """The reference."""
        r = self.reference
        return np.array([r.f_nat_hz, r.lambda_per_s, *([0.0] if self.jewel else []), *([0.0] * (2 + TURNS))])

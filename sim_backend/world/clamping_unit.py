"""What sits in the clamping unit: a rotor, which wears and swings on, or something else in its place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.specimen import Specimen
from sim_backend.options import SimulatedOptions
from sim_backend.receive.reference_dipole import Dipole
from sim_backend.rotor.decay import Resting, at_rest, decayed
from sim_backend.rotor.dynamics import dynamics
from sim_backend.rotor.rotor import Rotor
from sim_backend.transmit.coils import sensitivity_t_per_a

from .shot import conductance
from .variation import friction_factor, rotor_now, scattered


class ClampingUnit:
    """Pure bookkeeping in world time; the world's lock protects it.  `resting`: the rotor when it was last known."""

    def __init__(self, options: SimulatedOptions) -> None:
        self._options = options
        self.specimen: Specimen | None = None
        self.resting = Resting()
        self._rotor: Rotor | None = None
        self._last: Rotor | None = None  # as it was in the last shot
        self._instead: tuple[Dipole | None, NDArray[np.float64]] | None = None  # of the rotor, and where
        self._worn: dict[str, int] = {}

    def mount(self, specimen: Specimen, rotor: Rotor, now_s: float) -> None:
        """Put a resonator in; at rest unless it is the one already there, which goes on as it is."""
        self._instead = None
        if specimen != self.specimen:
            self.specimen, self._rotor, self._last = specimen, rotor, None
            self.hold_still(now_s)

    def insert(self, dipole: Dipole | None, position_m: NDArray[np.float64], now_s: float, *, empty: bool) -> None:
        """See World.insert."""
        self._instead = (dipole, position_m) if dipole is not None or empty else None
        self.hold_still(now_s)

    def hold_still(self, now_s: float) -> None:
        """Let the rotor hang at rest, if there is one."""
        if self._rotor is not None:
            self.resting = at_rest(now_s, dynamics(self._rotor, self._options.undeclared))

    def for_shot(self, deviation_k: float, rng: np.random.Generator) -> Rotor | None:
        """The rotor as it is in the shot that begins, with its wear; None: there is none, or something in its place."""
        self._last = None
        if self._rotor is None or self.specimen is None or self._instead is not None:
            return None
        worn = self._worn.get(self.specimen.name, 0)
        self._worn[self.specimen.name] = worn + 1
        friction = friction_factor(self._options.effects, rng, worn)
        turned = scattered(self._rotor, self.specimen.rotor.orientation_scatter_rad, rng)
        self._last = rotor_now(turned, self._options.effects, deviation_k, friction)
        return self._last

    def seen_from_coils(self, rotor: Rotor | None) -> tuple[Dipole | None, NDArray[np.float64]]:
        """The dipole in the rotor's place, if there is one, and the place, m."""
        return self._instead or (None, rotor.position_m if rotor else np.zeros(3))

    def rest_until(self, now_s: float, *, closed: bool) -> Resting:
        """The rotor now, after its free decay as it was in the last shot; closed: coils on the amplifier."""
        rotor = self._last or self._rotor
        if rotor is None or self._instead is not None:
            return Resting(now_s)
        along = sensitivity_t_per_a(self._options.coils, rotor.position_m) @ rotor.axes
        braking = conductance(self._options, rotor, along) if closed else None
        return decayed(self.resting, now_s, dynamics(rotor, self._options.undeclared), braking)

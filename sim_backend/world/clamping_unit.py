"""The content of the clamping unit: a rotor with its wear and its free decay, or a device inserted in its place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.specimen import Specimen
from sim_backend.options import SimulatedOptions
from sim_backend.receive.reference_dipole import Dipole
from sim_backend.rotor.decay import RotorState, at_rest, decayed
from sim_backend.rotor.rotor import Rotor
from sim_backend.transmit.coils import sensitivity_t_per_a

from .back_action import conductance
from .variation import (
    friction_factor,
    rotor_in_shot,
    under_pressure,
    with_fluctuations,
    with_scatter,
)


class ClampingUnit:
    """The content of the clamping unit in world time; callers hold the world's lock.

    specimen: the mounted one, None: none; rotor_state: the last state of the rotor that was computed.
    """

    def __init__(self, options: SimulatedOptions) -> None:
        self._options = options
        self.specimen: Specimen | None = None
        self.rotor_state = RotorState()
        self._rotor: Rotor | None = None
        self._last: Rotor | None = None  # with the variations of the last shot
        self._inserted: tuple[Dipole | None, NDArray[np.float64]] | None = (
            None  # device in place of the rotor, position
        )
        self._worn: dict[str, int] = {}

    def mount(self, specimen: Specimen, rotor: Rotor, options: SimulatedOptions, now_s: float) -> None:
        """Mount a resonator at rest; the same specimen as before keeps its present motion.

        options: of the world with this specimen.
        """
        self._inserted = None
        self._options = options
        if specimen != self.specimen:
            self.specimen = specimen
            self._rotor = rotor
            self._last = None
            self.hold_still(now_s)

    def insert(self, dipole: Dipole | None, position_m: NDArray[np.float64], now_s: float, *, empty: bool) -> None:
        """See World.insert."""
        self._inserted = (dipole, position_m) if dipole is not None or empty else None
        self.hold_still(now_s)

    def hold_still(self, now_s: float) -> None:
        """Set the rotor, if there is one, to rest."""
        if self._rotor is not None:
            from sim_backend.rotor.dynamics import dynamics  # here: it loads the compiler

            self.rotor_state = at_rest(now_s, dynamics(self._rotor, self._options.hidden_effects))

    def for_shot(self, now_s: float, deviation_k: float, rng: np.random.Generator) -> Rotor | None:
        """The rotor with the variations of a new shot, which adds wear; None: no rotor, or a device in its place."""
        self._last = None
        if self._rotor is None or self.specimen is None or self._inserted is not None:
            return None
        worn = self._worn.get(self.specimen.name, 0)
        self._worn[self.specimen.name] = worn + 1
        friction = friction_factor(self._options.effects, rng, worn)
        rotor = with_scatter(self._rotor, self.specimen.rotor, rng)
        rotor = with_fluctuations(rotor, self._options.hidden_effects, rng)
        warm = rotor_in_shot(rotor, self._options.effects, deviation_k, friction)
        self._last = under_pressure(warm, self._options.housing, now_s)
        return self._last

    def source_and_position(self, rotor: Rotor | None) -> tuple[Dipole | None, NDArray[np.float64]]:
        """The dipole in place of the rotor, if any, and the position of rotor or device, (3,), m."""
        return self._inserted or (None, rotor.position_m if rotor else np.zeros(3))

    def decayed_until(self, now_s: float, *, closed: bool) -> RotorState:
        """State of the rotor at `now_s` after its free decay with the variations of the last shot.

        closed: True if the coils are connected to the amplifier, which causes back-action.
        """
        rotor = self._last or self._rotor
        if rotor is None or self._inserted is not None:
            return RotorState(time_s=now_s)
        from sim_backend.rotor.dynamics import dynamics  # here for the same reason

        along = sensitivity_t_per_a(self._options.coils, rotor.position_m) @ rotor.axes
        braking = conductance(self._options, rotor, along) if closed else None
        return decayed(self.rotor_state, now_s, dynamics(rotor, self._options.hidden_effects), braking)

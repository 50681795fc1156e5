"""Everything that decides a shot before it is played."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import Timeline
from sim_backend.contacts import Contacts
from sim_backend.drive import Interval
from sim_backend.options import SimulatedOptions
from sim_backend.rotor import Rotor

BOUNCE, NOISE = 1, 2


@dataclass(frozen=True)
class ShotSetup:
    """Everything that decides a shot.

    number: from 1; start_s: world time of the trigger; stop_s: end after the trigger, the timeline's or that of a stop;
    live: intervals after the trigger in which the amplifier is enabled, unmuted and healthy; contacts: their history,
    time zero at the trigger; rotor: None if nothing is mounted; sensitivity_t_per_a: (coil, 3) at the rotor;
    hum_phases_rad: (harmonic, channel).
    """

    options: SimulatedOptions
    number: int
    start_s: float
    timeline: Timeline
    stop_s: float
    live: tuple[Interval, ...]
    contacts: Contacts
    rotor: Rotor | None
    phi_rad: float
    phi_dot_rad_per_s: float
    sensitivity_t_per_a: NDArray[np.float64]
    hum_phases_rad: NDArray[np.float64]
    lna_gain: float
    lna_broken: bool
    faults: frozenset[str]

    def rng(self, stream: int) -> np.random.Generator:
        """Random numbers that belong to this shot and stream alone."""
        return np.random.default_rng([self.options.seed, self.number, stream])

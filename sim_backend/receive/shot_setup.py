"""Everything that decides a shot before it is played."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import DigitalLine, Timeline
from sim_backend.options import SimulatedOptions
from sim_backend.rotor.motion import PIECE_SLOTS
from sim_backend.rotor.rotor import Rotor
from sim_backend.transmit.drive import Interval, both, high_intervals

from .contacts import Contacts
from .reference_dipole import Dipole

BOUNCE, NOISE = 1, 2


@dataclass(frozen=True)
class Earlier:
    """What one leg of an open-ended shot needs to know of the leg before, all times counted from its own start.

    leg: its number, from 1; rx_start_s: when the shot's first good RX sample is taken; currents_a: (coil,), in the
    coils; pieces (n, PIECE_SLOTS) and connected (n,): the last of the motion, which the receive chain still remembers.
    """

    leg: int
    rx_start_s: float
    currents_a: tuple[float, ...]
    pieces: NDArray[np.float64]
    connected: NDArray[np.bool_]


NOTHING_EARLIER = Earlier(0, 0.0, (), np.zeros((0, PIECE_SLOTS)), np.zeros(0, dtype=np.bool_))


@dataclass(frozen=True)
class ShotSetup:
    """Everything that decides a shot.

    number: from 1; start_s: world time of the trigger; stop_s: end after the trigger, the timeline's or that of a stop;
    live: intervals after the trigger in which the amplifier is enabled, unmuted and healthy; contacts: their history,
    time zero at the trigger; rotor: None if nothing is mounted; hidden: see `motion.Motion`;
    sensitivity_t_per_a: (coil, 3) at the rotor; hum_phases_rad: (harmonic, channel).

    A shot without a known end is a chain of legs, each a set-up of its own: `earlier` is what the leg continues, and
    the lines stay as they are at its end if it is `open_ended`.  delay_s: sample k shows the instant k / rate -
    delay_s.  dipole: what stands in the rotor's place, if it is the reference dipole.
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
    hidden: NDArray[np.float64]
    sensitivity_t_per_a: NDArray[np.float64]
    hum_phases_rad: NDArray[np.float64]
    lna_gain: float
    lna_broken: bool
    faults: frozenset[str]
    open_ended: bool = False
    earlier: Earlier = NOTHING_EARLIER
    delay_s: float = 0.0
    dipole: Dipole | None = None

    def rng(self, stream: int) -> np.random.Generator:
        """Random numbers that belong to this shot, leg and stream alone."""
        leg = [self.earlier.leg] if self.earlier.leg else []
        return np.random.default_rng([self.options.seed, self.number, stream, *leg])

    def rx_start_s(self) -> float:
        """When the first RX sample is taken, s after the trigger."""
        if self.earlier.leg:
            return self.earlier.rx_start_s
        return self.timeline.rx_start / self.timeline.clock.rate_hz

    def powered(self) -> list[Interval]:
        """When power reaches the output of the amplifier: live and gate open, s after the trigger."""
        live = both(self.live, [(0.0, self.stop_s)])
        return both(high_intervals(self.timeline, DigitalLine.PA_GATE), live)

    def trip_s(self) -> float:
        """When the fault `amplifier_trip` strikes: the middle of the transmit window."""
        return 0.5 * self.timeline.tx_samples / self.timeline.clock.rate_hz

    def with_trip(self) -> ShotSetup:
        """The same shot with the amplifier dead from the trip on, if it trips."""
        if "amplifier_trip" not in self.faults or self.earlier.leg:
            return self
        at_s = self.trip_s()
        return replace(self, live=tuple((a, min(b, at_s)) for a, b in self.live if a < at_s))

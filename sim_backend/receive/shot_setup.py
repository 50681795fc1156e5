"""Everything that determines a shot before it is simulated."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import DigitalLine, Timeline
from sim_backend.options import SimulatedOptions
from sim_backend.rotor.pieces import PIECE_SLOTS
from sim_backend.rotor.rotor import Rotor
from sim_backend.transmit.drive import Interval, high_intervals, intersection

from .reference_dipole import Dipole
from .relay_contacts import Contacts

BOUNCE, NOISE = 1, 2
MEMORY_S = 0.05  # responses of the receive chain and its transients have decayed after this time


@dataclass(frozen=True, kw_only=True)
class PreviousLeg:
    """State at the end of the previous leg of an open-ended shot; times count from the start of the present leg.

    leg: number of the present leg, 0: the first; rx_start_s: time of the shot's first good RX sample, s; currents_a:
    (coil,) currents in the coils, A; pieces (n, PIECE_SLOTS) and connected (n,): the last part of the motion, whose
    response in the receive chain has not decayed.
    """

    leg: int
    rx_start_s: float
    currents_a: tuple[float, ...]
    pieces: NDArray[np.float64]
    connected: NDArray[np.bool_]


NO_PREVIOUS_LEG = PreviousLeg(
    leg=0,
    rx_start_s=0.0,
    currents_a=(),
    pieces=np.zeros((0, PIECE_SLOTS)),
    connected=np.zeros(0, dtype=np.bool_),
)


@dataclass(frozen=True, kw_only=True)
class ShotSetup:
    """Everything that determines a shot.

    number: of the shot, from 1; start_s: world time of the trigger, s; stop_s: end of the timeline or time of a stop, s
    after the trigger; live: intervals after the trigger in which the amplifier is enabled, unmuted and without fault;
    contacts: their history, time zero at the trigger; rotor: None if none is mounted; internal_state: see
    `motion.Motion`; sensitivity_t_per_a: (coil, 3) at the rotor; hum_phases_rad: (harmonic, channel); dipole: the
    reference dipole, if it is inserted in place of the rotor; delay_s: sample k shows the instant k / rate - delay_s.

    A shot without a known end is a sequence of legs, each with a set-up of its own: `previous_leg` is the state that
    the leg continues, and at the end of an `open_ended` leg the digital lines keep their levels.
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
    internal_state: NDArray[np.float64]
    sensitivity_t_per_a: NDArray[np.float64]
    hum_phases_rad: NDArray[np.float64]
    lna_gain: float
    lna_broken: bool
    faults: frozenset[str]
    open_ended: bool = False
    previous_leg: PreviousLeg = NO_PREVIOUS_LEG
    delay_s: float = 0.0
    dipole: Dipole | None = None

    def rng(self, stream: int) -> np.random.Generator:
        """Generator of the random numbers of this shot, leg and stream."""
        leg = [self.previous_leg.leg] if self.previous_leg.leg else []
        return np.random.default_rng([self.options.seed, self.number, stream, *leg])

    def rx_start_s(self) -> float:
        """Time of the first RX sample, s after the trigger."""
        if self.previous_leg.leg:
            return self.previous_leg.rx_start_s
        return self.timeline.rx_start / self.timeline.clock.rate_hz

    def powered(self) -> list[Interval]:
        """Intervals in which power reaches the amplifier's output (live, gate open), s after the trigger."""
        live = intersection(self.live, [(0.0, self.stop_s)])
        return intersection(high_intervals(self.timeline, DigitalLine.PA_GATE), live)

    def trip_s(self) -> float:
        """Time of the fault `amplifier_trip`, the middle of the transmit window, s after the trigger."""
        return 0.5 * self.timeline.tx_samples / self.timeline.clock.rate_hz

    def with_trip(self) -> ShotSetup:
        """The same shot with the amplifier off from the trip on, if the fault plan contains one."""
        if "amplifier_trip" not in self.faults or self.previous_leg.leg:
            return self
        at_s = self.trip_s()
        return replace(self, live=tuple((a, min(b, at_s)) for a, b in self.live if a < at_s))

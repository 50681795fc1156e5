"""One shot of the simulated world as a pure function from its set-up to motion, currents and received signal.

The same shot with the amplifier switched off half-way, or truncated by a stop, gives the same samples up to that
instant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.receive.extra_signal import margin_s
from sim_backend.receive.receiver import ReceivedSignal, receive_signal
from sim_backend.receive.relay_contacts import Contacts
from sim_backend.receive.shot_setup import BOUNCE, MEMORY_S, PreviousLeg, ShotSetup
from sim_backend.rotor.dynamics import dynamics
from sim_backend.rotor.pieces import NO_FIELD, PIECE_SLOTS, START, Motion
from sim_backend.rotor.trajectory import states
from sim_backend.transmit.drive import Cut, Interval, amplifier_channels, cuts, high_intervals, intersection

from .back_action import conductance

WORSE_BOUNCE = 10


@dataclass(frozen=True, kw_only=True)
class ShotResult:
    """Result of a shot; times in s after the trigger.

    pieces: motion, (n, PIECE_SLOTS); phi_rad, phi_dot_rad_per_s, internal_state, stuck: at the end, see
    `motion.Motion`; contacts: their history; cuts: currents; powered: intervals in which power could reach the coils;
    violations: (time, cause) of the interlock; clipped_s: when the amplifier first clipped, None: never; receive:
    computes the received signal.
    """

    pieces: NDArray[np.float64]
    phi_rad: float
    phi_dot_rad_per_s: float
    internal_state: NDArray[np.float64]
    stuck: bool
    contacts: Contacts
    cuts: tuple[Cut, ...]
    powered: tuple[Interval, ...]
    violations: tuple[tuple[float, str], ...]
    clipped_s: float | None
    receive: Callable[[], ReceivedSignal]

    @cached_property
    def received(self) -> ReceivedSignal:
        """The received signal, computed on first access."""
        return self.receive()


def simulate(setup: ShotSetup) -> ShotResult:
    """Simulate a shot: currents, motion, violations.  Raises DeviceError if the motion cannot be integrated."""
    contacts = contacts_through_shot(setup)
    spans = contacts.spans(0.0, setup.stop_s)
    powered = setup.powered()
    coils = setup.options.coils.in_order()
    drives = amplifier_channels(setup.timeline, setup.options.amplifier, len(coils), setup.options.wiring)
    impedance_ohm = setup.options.amplifier.output_impedance_ohm
    shot_cuts = cuts(drives, powered, spans, coils, impedance_ohm, setup.previous_leg.currents_a)
    motion, connected = _motion(setup, shot_cuts)
    violations = _violations(powered, spans)
    broken_s = 0.0 if setup.lna_broken else min((t for t, _ in violations), default=np.inf)
    contact_spans = contacts.spans(-MEMORY_S, setup.stop_s) if setup.previous_leg.leg else spans

    def receive() -> ReceivedSignal:
        pieces, piece_connected = _with_neighbours(setup, motion, connected)
        return receive_signal(
            setup,
            pieces=pieces,
            connected=piece_connected,
            spans=contact_spans,
            leak_v=_leak_v(setup, powered),
            broken_s=broken_s,
        )

    return ShotResult(
        pieces=motion.pieces,
        phi_rad=motion.phi_rad,
        phi_dot_rad_per_s=motion.phi_dot_rad_per_s,
        internal_state=motion.internal_state,
        stuck=motion.stuck,
        contacts=contacts,
        cuts=tuple(shot_cuts),
        powered=tuple(powered),
        violations=violations,
        clipped_s=min((c.start_s for c in shot_cuts if c.clipped), default=None),
        receive=receive,
    )


def next_leg(setup: ShotSetup, result: ShotResult, timeline: Timeline, live: tuple[Interval, ...]) -> ShotSetup:
    """The set-up of the next leg of an open-ended shot, which begins at the end of `setup`; live: see ShotSetup."""
    at_s = setup.stop_s
    recent = result.pieces[:, START] > at_s - MEMORY_S
    pieces = result.pieces[recent].copy()
    pieces[:, START] -= at_s
    currents_a = tuple(float(result.cuts[-1].current_a(k, np.array([at_s]))[0]) for k in range(3))
    connected = np.array([result.contacts.position(a) is SwitchPosition.RECEIVE for a in pieces[:, START] + at_s])
    previous_leg = PreviousLeg(
        leg=setup.previous_leg.leg + 1,
        rx_start_s=setup.rx_start_s() - at_s,
        currents_a=currents_a,
        pieces=pieces,
        connected=connected.astype(np.bool_),
    )
    return replace(
        setup,
        start_s=setup.start_s + at_s,
        timeline=timeline,
        stop_s=timeline.duration_s,
        live=live,
        contacts=result.contacts.shifted(-at_s),
        rotor=setup.rotor and setup.rotor.later(at_s),
        phi_rad=result.phi_rad,
        phi_dot_rad_per_s=result.phi_dot_rad_per_s,
        internal_state=result.internal_state,
        lna_broken=setup.lna_broken or bool(result.violations),
        previous_leg=previous_leg,
    )


def truncated(setup: ShotSetup, result: ShotResult, stop_s: float) -> tuple[ShotSetup, ShotResult]:
    """The shot ended at stop_s, without a new simulation unless the rotor has an internal state."""
    setup = replace(setup, stop_s=stop_s)
    if setup.rotor is not None and (result.internal_state.size or not result.pieces.size):
        return setup, simulate(setup)
    pieces = result.pieces[result.pieces[:, START] < stop_s]
    phi, phi_dot = setup.phi_rad, setup.phi_dot_rad_per_s
    if len(pieces):
        phi, phi_dot = (float(x[0]) for x in states(pieces[-1:], np.array([stop_s])))
    kept = tuple(replace(c, stop_s=min(c.stop_s, stop_s)) for c in result.cuts if c.start_s < stop_s)

    def receive() -> ReceivedSignal:
        samples, overload_s = int(np.ceil(stop_s * setup.timeline.clock.rate_hz)), result.received.overload_s
        known_s = None if overload_s is None or overload_s > stop_s else overload_s
        return replace(result.received, volts=result.received.volts[:, :samples], overload_s=known_s)

    return setup, replace(
        result,
        pieces=pieces,
        phi_rad=phi,
        phi_dot_rad_per_s=phi_dot,
        contacts=contacts_through_shot(setup),
        cuts=kept,
        powered=tuple(intersection(result.powered, [(0.0, stop_s)])),
        violations=tuple(v for v in result.violations if v[0] < stop_s),
        clipped_s=min((c.start_s for c in kept if c.clipped), default=None),
        receive=receive,
    )


def contacts_through_shot(setup: ShotSetup) -> Contacts:
    """The contacts through the shot: they follow the line RX_CONNECT and return to TRANSMIT at its end."""
    rng = setup.rng(BOUNCE)
    contacts = setup.contacts.with_stuck(setup.contacts.stuck or "switch_stuck" in setup.faults)
    if "relay_bounce" in setup.faults:
        contacts = contacts.with_options(setup.options.switch.worn(WORSE_BOUNCE))
    high = intersection(high_intervals(setup.timeline, DigitalLine.RX_CONNECT), [(0.0, setup.stop_s)])
    if not high or high[0][0] > 0:
        contacts = contacts.command(0.0, SwitchPosition.TRANSMIT, rng)
    for rise_s, fall_s in high:
        contacts = contacts.command(rise_s, SwitchPosition.RECEIVE, rng)
        contacts = contacts.with_stuck(contacts.stuck or "switch_welded" in setup.faults)
        if fall_s < setup.timeline.duration_s or not setup.open_ended:
            contacts = contacts.command(fall_s, SwitchPosition.TRANSMIT, rng)
    return contacts


def _motion(setup: ShotSetup, shot_cuts: list[Cut]) -> tuple[Motion, NDArray[np.bool_]]:
    """The motion through the whole shot, and for each piece whether the receiver is connected, (pieces,) bool."""
    now = Motion(
        pieces=np.zeros((0, PIECE_SLOTS)),
        phi_rad=setup.phi_rad,
        phi_dot_rad_per_s=setup.phi_dot_rad_per_s,
        stuck=False,
        internal_state=setup.internal_state,
    )
    if setup.rotor is None:
        return now, np.zeros(0, dtype=np.bool_)
    along = setup.sensitivity_t_per_a @ setup.rotor.axes  # a field along w has no torque about w
    braking = conductance(setup.options, setup.rotor, along)
    model = dynamics(setup.rotor, setup.options.hidden_effects)
    pieces, flags = [], []
    for cut in shot_cuts:
        closed = cut.position is SwitchPosition.TRANSMIT
        terms = cut.field_terms(along) if closed else NO_FIELD
        now = model.advance(
            cut.start_s,
            cut.stop_s,
            now,
            terms,
            conductance=braking if closed else None,
            drift_from_s=setup.rx_start_s() - cut.start_s,
        )
        pieces.append(now.pieces)
        flags.append(np.full(len(now.pieces), cut.position is SwitchPosition.RECEIVE))
    return replace(now, pieces=np.concatenate(pieces)), np.concatenate(flags)


def _with_neighbours(
    setup: ShotSetup, motion: Motion, connected: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Pieces and their flags, with the last ones of the previous leg and with the free swing after the end.

    Some hidden effects need the motion after the end.
    """
    pieces = motion.pieces
    if setup.previous_leg.leg:
        pieces = np.concatenate([setup.previous_leg.pieces, pieces])
        connected = np.concatenate([setup.previous_leg.connected, connected])
    margin = margin_s(setup.options.hidden_effects, setup.timeline.clock.rate_hz)
    if setup.rotor is None or margin == 0.0:
        return pieces, connected
    end_s = setup.stop_s
    model = dynamics(setup.rotor, setup.options.hidden_effects)
    more = model.advance(end_s, end_s + margin, motion, drift_from_s=setup.rx_start_s() - end_s).pieces
    return np.concatenate([pieces, more]), np.append(connected, np.full(len(more), connected[-1]))


def amplifier_v(setup: ShotSetup, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Output of the amplifier if the gate were always open, clipped, at times (n,): (channel, n) float64, V."""
    drives = amplifier_channels(setup.timeline, setup.options.amplifier, 3, setup.options.wiring)
    return np.stack([np.clip(d.wanted_at(times_s), -d.limit_v, d.limit_v) for d in drives])


def _leak_v(setup: ShotSetup, powered: list[Interval]) -> NDArray[np.float64]:
    """Leakage of the transmit voltage through the open receive contacts at the LNA input: (channel, n), V."""
    rate = setup.timeline.clock.rate_hz
    last_s = max((b for _, b in powered), default=-setup.delay_s) + setup.delay_s
    t = np.arange(min(int(np.ceil(last_s * rate)), setup.timeline.total_samples)) / rate - setup.delay_s
    on = np.any([(t >= a) & (t < b) for a, b in powered], axis=0) if powered else np.zeros(t.size, dtype=bool)
    return amplifier_v(setup, t) * on * 10 ** (-setup.options.switch.isolation_db / 20)


def _violations(
    powered: list[Interval], spans: list[tuple[float, float, SwitchPosition]]
) -> tuple[tuple[float, str], ...]:
    connected = [(a, b) for a, b, position in spans if position is SwitchPosition.RECEIVE]
    return tuple(
        (a, f"receiver connected to the live amplifier for {1e3 * (b - a):.3g} ms")
        for a, b in intersection(powered, connected)
    )

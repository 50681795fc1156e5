"""One shot of the simulated world as a pure function: set-up and commands in, what happened and was heard out.

It can be repeated with the amplifier switched off half-way, or cut short by a stop, and gives the same samples up to
that instant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import SimulatedOptions
from sim_backend.receive.contacts import Contacts
from sim_backend.receive.extra_signal import listening_tail_s
from sim_backend.receive.receiver import Heard, listen
from sim_backend.receive.shot_setup import BOUNCE, Earlier, ShotSetup
from sim_backend.rotor.dynamics import dynamics
from sim_backend.rotor.motion import NO_FIELD, PIECE_SLOTS, START, Motion
from sim_backend.rotor.rotor import Rotor
from sim_backend.rotor.trajectory import states
from sim_backend.transmit.drive import Cut, Interval, both, cuts, high_intervals, sources

MEMORY_S = 0.05  # the receive chain and its transients have forgotten what is longer ago
WORSE_BOUNCE = 10


@dataclass(frozen=True)
class ShotResult:
    """What happened.

    pieces: motion, (n, PIECE_SLOTS); phi_rad, phi_dot_rad_per_s, hidden, stuck: at the end, see `motion.Motion`;
    cuts: currents; powered: when power could reach the coils; violations: (s after the trigger, cause) of the
    interlock; clipped_s: when the amplifier first clipped, None: never; listening: makes the receive side.
    """

    pieces: NDArray[np.float64]
    phi_rad: float
    phi_dot_rad_per_s: float
    hidden: NDArray[np.float64]
    stuck: bool
    contacts: Contacts
    cuts: tuple[Cut, ...]
    powered: tuple[Interval, ...]
    violations: tuple[tuple[float, str], ...]
    clipped_s: float | None
    listening: Callable[[], Heard]

    @cached_property
    def heard(self) -> Heard:
        """The receive side, computed when somebody listens."""
        return self.listening()


def simulate(setup: ShotSetup) -> ShotResult:
    """Play the timeline, move the rotor, record.  Raises DeviceError if the motion cannot be solved."""
    contacts = commanded(setup)
    spans = contacts.spans(0.0, setup.stop_s)
    powered = setup.powered()
    coils = setup.options.coils.in_order()
    drives = sources(setup.timeline, setup.options.amplifier, len(coils), setup.options.wiring)
    impedance_ohm = setup.options.amplifier.output_impedance_ohm
    stages = cuts(drives, powered, spans, coils, impedance_ohm, setup.earlier.currents_a)
    motion, connected = _motion(setup, stages)
    violations = _violations(powered, spans)
    broken_s = 0.0 if setup.lna_broken else min((t for t, _ in violations), default=np.inf)
    heard_of = contacts.spans(-MEMORY_S, setup.stop_s) if setup.earlier.leg else spans

    def listening() -> Heard:
        return listen(setup, *_in_context(setup, motion, connected), heard_of, _leak_v(setup, powered), broken_s)

    clipped_s = min((c.start_s for c in stages if c.clipped), default=None)
    return ShotResult(
        motion.pieces,
        motion.phi_rad,
        motion.phi_dot_rad_per_s,
        motion.hidden,
        motion.stuck,
        contacts,
        tuple(stages),
        tuple(powered),
        violations,
        clipped_s,
        listening,
    )


def after(setup: ShotSetup, result: ShotResult, timeline: Timeline, live: tuple[Interval, ...]) -> ShotSetup:
    """The set-up of the next leg of an open-ended shot, which begins where `setup` ends; live as in ShotSetup."""
    at_s = setup.stop_s
    recent = result.pieces[:, START] > at_s - MEMORY_S
    pieces = result.pieces[recent].copy()
    pieces[:, START] -= at_s
    currents_a = tuple(float(result.cuts[-1].current_a(k, np.array([at_s]))[0]) for k in range(3))
    connected = np.array([result.contacts.position(a) is SwitchPosition.RECEIVE for a in pieces[:, START] + at_s])
    earlier = Earlier(setup.earlier.leg + 1, setup.rx_start_s() - at_s, currents_a, pieces, connected.astype(np.bool_))
    return replace(
        setup,
        start_s=setup.start_s + at_s,
        timeline=timeline,
        stop_s=timeline.duration_s,
        live=live,
        contacts=result.contacts.shifted(-at_s),
        phi_rad=result.phi_rad,
        phi_dot_rad_per_s=result.phi_dot_rad_per_s,
        hidden=result.hidden,
        lna_broken=setup.lna_broken or bool(result.violations),
        earlier=earlier,
    )


def cut_short(setup: ShotSetup, result: ShotResult, stop_s: float) -> tuple[ShotSetup, ShotResult]:
    """The same shot ended at stop_s, without computing it again; exact unless an undeclared effect has a memory."""
    setup = replace(setup, stop_s=stop_s)
    if setup.rotor is not None and (result.hidden.size or not result.pieces.size):
        return setup, simulate(setup)
    pieces = result.pieces[result.pieces[:, START] < stop_s]
    phi, phi_dot = setup.phi_rad, setup.phi_dot_rad_per_s
    if len(pieces):
        phi, phi_dot = (float(x[0]) for x in states(pieces[-1:], np.array([stop_s])))
    kept = tuple(replace(c, stop_s=min(c.stop_s, stop_s)) for c in result.cuts if c.start_s < stop_s)

    def listening() -> Heard:
        samples, overload_s = int(np.ceil(stop_s * setup.timeline.clock.rate_hz)), result.heard.overload_s
        known_s = None if overload_s is None or overload_s > stop_s else overload_s
        return replace(result.heard, volts=result.heard.volts[:, :samples], overload_s=known_s)

    return setup, replace(
        result,
        pieces=pieces,
        phi_rad=phi,
        phi_dot_rad_per_s=phi_dot,
        contacts=commanded(setup),
        cuts=kept,
        powered=tuple(both(result.powered, [(0.0, stop_s)])),
        violations=tuple(v for v in result.violations if v[0] < stop_s),
        clipped_s=min((c.start_s for c in kept if c.clipped), default=None),
        listening=listening,
    )


def commanded(setup: ShotSetup) -> Contacts:
    """The contacts through the shot: they follow the line RX_CONNECT and go home at its end."""
    rng = setup.rng(BOUNCE)
    contacts = setup.contacts.jam(setup.contacts.stuck or "switch_stuck" in setup.faults)
    if "relay_bounce" in setup.faults:
        contacts = contacts.like(setup.options.switch.worn(WORSE_BOUNCE))
    high = both(high_intervals(setup.timeline, DigitalLine.RX_CONNECT), [(0.0, setup.stop_s)])
    if not high or high[0][0] > 0:
        contacts = contacts.command(0.0, SwitchPosition.TRANSMIT, rng)
    for rise_s, fall_s in high:
        contacts = contacts.command(rise_s, SwitchPosition.RECEIVE, rng)
        contacts = contacts.jam(contacts.stuck or "switch_welded" in setup.faults)
        if fall_s < setup.timeline.duration_s or not setup.open_ended:
            contacts = contacts.command(fall_s, SwitchPosition.TRANSMIT, rng)
    return contacts


def _motion(setup: ShotSetup, stages: list[Cut]) -> tuple[Motion, NDArray[np.bool_]]:
    """The motion through the whole shot, and which of its pieces the receiver is connected to."""
    now = Motion(np.zeros((0, PIECE_SLOTS)), setup.phi_rad, setup.phi_dot_rad_per_s, False, setup.hidden)
    if setup.rotor is None:
        return now, np.zeros(0, dtype=np.bool_)
    along = setup.sensitivity_t_per_a @ setup.rotor.axes  # a field along w has no torque about w
    braking = conductance(setup.options, setup.rotor, along)
    model = dynamics(setup.rotor, setup.options.undeclared)
    pieces, flags = [], []
    for cut in stages:
        closed = cut.position is SwitchPosition.TRANSMIT
        terms = cut.field_terms(along) if closed else NO_FIELD
        drift_from_s = setup.rx_start_s() - cut.start_s
        now = model.advance(cut.start_s, cut.stop_s, now, terms, braking if closed else None, drift_from_s)
        pieces.append(now.pieces)
        flags.append(np.full(len(now.pieces), cut.position is SwitchPosition.RECEIVE))
    return replace(now, pieces=np.concatenate(pieces)), np.concatenate(flags)


def _in_context(
    setup: ShotSetup, motion: Motion, connected: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Pieces and their flags, with the last of the leg before, and with the free swing beyond the end that some
    undeclared effects listen to."""
    pieces = motion.pieces
    if setup.earlier.leg:
        pieces = np.concatenate([setup.earlier.pieces, pieces])
        connected = np.concatenate([setup.earlier.connected, connected])
    tail_s = listening_tail_s(setup.options.undeclared, setup.timeline.clock.rate_hz)
    if setup.rotor is None or tail_s == 0.0:
        return pieces, connected
    end_s = setup.stop_s
    model = dynamics(setup.rotor, setup.options.undeclared)
    more = model.advance(end_s, end_s + tail_s, motion, drift_from_s=setup.rx_start_s() - end_s).pieces
    return np.concatenate([pieces, more]), np.append(connected, np.full(len(more), connected[-1]))


def conductance(options: SimulatedOptions, rotor: Rotor, along: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """(k, k) sum of b b^T Re(1/Z) over the closed transmit loops at f_nat, for the torques; None: effect off.

    along: (coil, k) field per ampere along u, v and, of a rigid body, w, T/A.
    The loop current that the rotor induces is taken in its steady state at f_nat; its reactive part would only shift
    the frequency by a few parts per million.
    """
    effect = options.effects.back_action
    if not effect.enabled:
        return None
    ohms = [c.resistance_ohm + options.amplifier.output_impedance_ohm for c in options.coils.in_order()]
    henries = [c.inductance_h for c in options.coils.in_order()]
    admittance = [(1 / complex(r, rotor.omega_rad_per_s * x)).real for r, x in zip(ohms, henries, strict=True)]
    return effect.scale * np.einsum("c,ci,cj->ij", np.array(admittance), along, along)


def amplifier_v(setup: ShotSetup, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """What the amplifier would put out with the gate always open, clipped: (channel, n) float64, V."""
    drives = sources(setup.timeline, setup.options.amplifier, 3, setup.options.wiring)
    return np.stack([np.clip(d.wanted_at(times_s), -d.limit_v, d.limit_v) for d in drives])


def _leak_v(setup: ShotSetup, powered: list[Interval]) -> NDArray[np.float64]:
    """Leakage of the transmit voltage through the open receive contacts, at the LNA input: (channel, n), V."""
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
        (a, f"receiver connected to the live amplifier for {1e3 * (b - a):.3g} ms") for a, b in both(powered, connected)
    )

"""From the DAC to the current in the coils: amplifier with its limit, then an R-L loop, solved exactly.

Time is divided wherever anything changes (burst, gate, amplifier, contacts, clipping).  In each such cut the source
v(t) is a sum of sines or a constant, and L di/dt + R i = v has a closed solution: each sine of amplitude V and
frequency omega gives a sine of amplitude V/|R + i omega L|, a constant V gives V/R, and one exponential exp(-R t/L)
keeps the current continuous.  Nothing is sampled, so the result does not depend on a step size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import Burst, DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import AmplifierOptions, CoilOptions, WiringOptions

Interval = tuple[float, float]
Times = TypeVar("Times", float, NDArray[np.float64])
NEGLIGIBLE_A = 1e-16
HEAT_STEP_S = 1e-5
CORRECT_WIRING = WiringOptions()
SAMPLE_TOLERANCE = 1e-6  # of a sample: rounding of sample times


@dataclass(frozen=True, kw_only=True)
class CurrentTerm:
    """The current amplitude_a exp(-rate tau) cos(omega tau + phase), tau in s from the start of its cut."""

    amplitude_a: float
    omega_rad_per_s: float
    phase_rad: float
    rate_per_s: float

    def at(self, tau: NDArray[np.float64]) -> NDArray[np.float64]:
        """Current at times tau (n,), s after the start of the cut: (n,), A."""
        shape = np.cos(self.omega_rad_per_s * tau + self.phase_rad) * np.exp(-self.rate_per_s * tau)
        return np.asarray(self.amplitude_a * shape)


@dataclass(frozen=True, kw_only=True)
class Cut:
    """An interval in which nothing changes.

    start_s, stop_s: s after the trigger; position: of the contacts; currents: terms of each coil's current; clipped:
    True if an amplifier channel is at its limit.
    """

    start_s: float
    stop_s: float
    position: SwitchPosition
    currents: tuple[tuple[CurrentTerm, ...], ...]
    clipped: bool = False

    def current_a(self, coil: int, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Current of one coil at times (n,) inside the cut, s after the trigger: (n,), A."""
        tau = times_s - self.start_s
        return np.sum([term.at(tau) for term in self.currents[coil]], axis=0) if self.currents[coil] else 0.0 * tau

    def field_terms(self, per_ampere_t: NDArray[np.float64]) -> NDArray[np.float64]:
        """Terms of the field at the rotor: (n, 5) for `torque.field`, (n, 6) for the rigid body.

        per_ampere_t: (coil, 2) along u, v or (coil, 3) along u, v, w, T/A.
        """
        rows = [
            [*(t.amplitude_a * b[:2]), t.omega_rad_per_s, t.phase_rad, t.rate_per_s, *(t.amplitude_a * b[2:])]
            for b, terms in zip(per_ampere_t, self.currents, strict=True)
            for t in terms
        ]
        return np.array(rows, dtype=np.float64).reshape(-1, 3 + per_ampere_t.shape[1])


@dataclass(frozen=True, kw_only=True)
class AmplifierChannel:
    """One amplifier channel.

    bursts: of its DAC output; rate_hz: sampling rate; gain: voltage gain, V/V; limit_v: output limit, V.
    """

    bursts: tuple[Burst, ...]
    rate_hz: float
    gain: float
    limit_v: float

    def active(self, time_s: float) -> list[Burst]:
        """Bursts that are active at a time, s after the trigger."""
        return [b for b in self.bursts if b.start_sample <= time_s * self.rate_hz < b.stop_sample]

    def wanted_v(self, time_s: float, bursts: Sequence[Burst]) -> float:
        """Sum of the given bursts after the gain and before the limit, V."""
        return sum(self.gain * b.amplitude_v * np.sin(self.phase(b, time_s)) for b in bursts)

    def wanted_at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Output before the limit at ascending times (n,), s after the trigger: (n,) float64, V."""
        volts = np.zeros(times_s.size)
        samples = times_s * self.rate_hz + SAMPLE_TOLERANCE
        for b in self.bursts:
            on = slice(*np.searchsorted(samples, (b.start_sample, b.stop_sample)))
            turn = 2 * np.pi * b.frequency_hz * (times_s[on] - b.start_sample / self.rate_hz) + b.phase_rad
            volts[on] += self.gain * b.amplitude_v * np.sin(turn)
        return volts

    def phase(self, burst: Burst, time_s: Times) -> Times:
        """Phase of a burst at one time or at several, rad."""
        start_s = burst.start_sample / self.rate_hz
        return 2 * np.pi * burst.frequency_hz * (time_s - start_s) + burst.phase_rad

    def is_clipped(self, time_s: float) -> bool:
        """True if the limit is exceeded at a time, s after the trigger."""
        return abs(self.wanted_v(time_s, self.active(time_s))) > self.limit_v

    def edges(self) -> list[float]:
        """Starts and stops of the bursts, s after the trigger."""
        return [k / self.rate_hz for b in self.bursts for k in (b.start_sample, b.stop_sample)]

    def clip_edges(self, start_s: float, stop_s: float) -> list[float]:
        """Times inside an interval without burst edges at which the limit is reached or left."""
        bursts = self.active(0.5 * (start_s + stop_s))
        if sum(abs(b.amplitude_v) for b in bursts) * abs(self.gain) <= self.limit_v:
            return []
        from scipy.optimize import brentq  # here: it takes long to load, and few drives clip

        per_period = 200 if len(bursts) == 1 else 20
        points = int((stop_s - start_s) * max(b.frequency_hz for b in bursts) * per_period) + 50
        grid = np.linspace(start_s, stop_s, points)

        def excess(t: float) -> float:
            return abs(self.wanted_v(t, bursts)) - self.limit_v

        values = np.abs(sum(b.amplitude_v * self.gain * np.sin(self.phase(b, grid)) for b in bursts)) - self.limit_v
        flips = np.flatnonzero(np.signbit(values[:-1]) != np.signbit(values[1:]))
        return [float(brentq(excess, grid[i], grid[i + 1], xtol=1e-15)) for i in flips]


def high_intervals(timeline: Timeline, line: DigitalLine) -> list[Interval]:
    """Intervals in which a digital line is high, s after the trigger, overlapping ones merged."""
    rate = timeline.clock.rate_hz
    spans = sorted((e.start_sample / rate, e.stop_sample / rate) for e in timeline.lines if e.line is line)
    return _merged(spans)


def intersection(first: Sequence[Interval], second: Sequence[Interval]) -> list[Interval]:
    """Intersection of two sets of intervals."""
    pairs = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return [(a, b) for a, b in sorted(pairs) if a < b]


def amplifier_channels(
    timeline: Timeline, amplifier: AmplifierOptions, channels: int, wiring: WiringOptions = CORRECT_WIRING
) -> list[AmplifierChannel]:
    """The channel that drives each coil; coil k is connected to DAC output k unless the wiring is wrong."""
    return [
        AmplifierChannel(
            bursts=tuple(b for b in timeline.bursts if b.output == wiring.outputs[k]),
            rate_hz=timeline.clock.rate_hz,
            gain=amplifier.gain * wiring.factors[k],
            limit_v=amplifier.limit_v,
        )
        for k in range(channels)
    ]


def cuts(
    drives: Sequence[AmplifierChannel],
    live: Sequence[Interval],
    contacts: Sequence[tuple[float, float, SwitchPosition]],
    coils: Sequence[CoilOptions],
    output_impedance_ohm: float,
    initial_a: Sequence[float] = (),
) -> list[Cut]:
    """All cuts of a shot, which cover the contact spans (s after the trigger) without gaps.

    live: intervals in which the power stage is on; while it is off, its outputs hold zero volts and a remaining current
    decays with L/R; initial_a: current of each coil at the start, A, empty: zero.  Contacts that are not on TRANSMIT
    open the loop: the current is zero.
    """
    out: list[Cut] = []
    for start_s, stop_s, position in _grid(drives, live, contacts):
        closed = position is SwitchPosition.TRANSMIT
        powered = any(a <= 0.5 * (start_s + stop_s) < b for a, b in live)
        middle_s = 0.5 * (start_s + stop_s)
        clipped = powered and any(s.is_clipped(middle_s) for s in drives)
        terms = []
        for k, (source, coil) in enumerate(zip(drives, coils, strict=True)):
            first_a = initial_a[k] if initial_a else 0.0
            before_a = float(out[-1].current_a(k, np.array([start_s]))[0]) if out else first_a
            terms.append(
                _loop_terms(
                    source,
                    powered=powered,
                    start_s=start_s,
                    stop_s=stop_s,
                    initial_a=before_a,
                    ohm=coil.resistance_ohm + output_impedance_ohm,
                    henry=coil.inductance_h,
                )
                if closed
                else ()
            )
        out.append(Cut(start_s=start_s, stop_s=stop_s, position=position, currents=tuple(terms), clipped=clipped))
    return out


def _grid(
    drives: Sequence[AmplifierChannel],
    live: Sequence[Interval],
    contacts: Sequence[tuple[float, float, SwitchPosition]],
) -> list[tuple[float, float, SwitchPosition]]:
    switching = [t for interval in live for t in interval] + [t for s in drives for t in s.edges()]
    out = []
    for start_s, stop_s, position in contacts:
        edges = sorted({start_s, stop_s, *(t for t in switching if start_s < t < stop_s)})
        clips = [t for s in drives for a, b in pairwise(edges) for t in s.clip_edges(a, b)]
        edges = sorted({*edges, *clips})
        out += [(a, b, position) for a, b in pairwise(edges)]
    return out


def _loop_terms(
    source: AmplifierChannel,
    *,
    powered: bool,
    start_s: float,
    stop_s: float,
    initial_a: float,
    ohm: float,
    henry: float,
) -> tuple[CurrentTerm, ...]:
    """Current of L di/dt + R i = v in one cut, from its value at the start."""
    middle_s = 0.5 * (start_s + stop_s)
    bursts = source.active(middle_s) if powered else []
    wanted = source.wanted_v(middle_s, bursts)
    if abs(wanted) > source.limit_v:
        forced = [_constant_term(np.copysign(source.limit_v, wanted) / ohm)]
    else:
        forced = [_sine_term(source, b, start_s, ohm, henry) for b in bursts]
    rest_a = initial_a - float(sum(term.at(np.zeros(1))[0] for term in forced))
    terms = [*forced, _constant_term(rest_a, rate_per_s=ohm / henry)]
    return tuple(t for t in terms if abs(t.amplitude_a) > NEGLIGIBLE_A)


def _sine_term(source: AmplifierChannel, burst: Burst, start_s: float, ohm: float, henry: float) -> CurrentTerm:
    omega = 2 * np.pi * burst.frequency_hz
    impedance = complex(ohm, omega * henry)
    phase = source.phase(burst, start_s) - np.angle(impedance) - np.pi / 2
    amplitude_a = source.gain * burst.amplitude_v / abs(impedance)
    return CurrentTerm(amplitude_a=amplitude_a, omega_rad_per_s=omega, phase_rad=float(phase), rate_per_s=0.0)


def _constant_term(amplitude_a: float, rate_per_s: float = 0.0) -> CurrentTerm:
    """A constant current, or one that decays at a rate."""
    return CurrentTerm(amplitude_a=amplitude_a, omega_rad_per_s=0.0, phase_rad=0.0, rate_per_s=rate_per_s)


def delivered_j(cuts_of_shot: Sequence[Cut], coils: Sequence[CoilOptions]) -> float:
    """Energy dissipated in the coils, J, by the trapezoidal rule on a fine grid."""
    total = 0.0
    for cut in cuts_of_shot:
        for k, coil in enumerate(coils):
            if cut.currents[k]:
                t = np.linspace(cut.start_s, cut.stop_s, int((cut.stop_s - cut.start_s) / HEAT_STEP_S) + 2)
                total += coil.resistance_ohm * float(np.trapezoid(cut.current_a(k, t) ** 2, t))
    return total


def _merged(spans: Sequence[Interval]) -> list[Interval]:
    out: list[Interval] = []
    for start, stop in spans:
        if out and start <= out[-1][1]:
            out[-1] = (out[-1][0], max(out[-1][1], stop))
        else:
            out.append((start, stop))
    return out

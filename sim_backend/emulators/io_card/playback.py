"""From a card's registers to what its outputs and lines do: bursts of sines in samples after the trigger.

A card's history is a list of (sample, registers from then on), beginning with sample 0 at the trigger.  The sum of an
output: enable x (sequence value + offset + waveforms + table) x ramp, with waveforms running on underneath.  Periodic
waveforms are sums of sines, because the coils' currents are solved for sines in closed form.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import Burst

from .registers import COMPONENTS, OUTPUTS, Output, Program, Registers

History = Sequence[tuple[int, Registers]]
Spans = list[tuple[int, int]]
Partials = tuple[tuple[int, float, float], ...]

HARMONICS = 40
NEGLIGIBLE = 1e-6
RAMP_STAIRS = 32
HIGH_V = 0.9


def output_bursts(history: History, output: int, axis: int, first: int, last: int, rate_hz: float) -> tuple[Burst, ...]:
    """What one output plays in samples first..last, counted from `first`; bursts carry `axis` as their output."""
    out: list[Burst] = []
    turns = np.zeros(COMPONENTS + 1)
    ramp = _Ramp(history, output, rate_hz)
    for (start, registers), stop in _stretches(history, last):
        if start >= last:
            break
        channel = registers.outputs[output]
        frequencies = np.array([c.frequency_hz for c in channel.components])
        for a, b, enabled, value, silent, restarts in _runs(registers, output, start, stop):
            if enabled and not registers.muted and b > first and a < last:
                for c, d, factor in ramp.stairs(max(a, first), min(b, last)):
                    now = turns + frequencies * ((c - a) / rate_hz)
                    player = channel.silenced() if silent else channel
                    out += _tones(player, value, now, factor, axis, c - first, d - first, rate_hz)
            turns = np.zeros_like(turns) if restarts else (turns + frequencies * ((b - a) / rate_hz)) % 2**20
    return tuple(out)


def high_spans(history: History, pin: str | None, pdm: int | None, first: int, last: int) -> Spans:
    """When a digital line is high in samples first..last: a pin, or one of the sequence's slow outputs."""
    out: Spans = []
    for (start, registers), stop in _stretches(history, last):
        spans = [(start, stop, pin in registers.pins)] if pin is not None else []
        if pdm is not None and registers.program is not None and not registers.muted:
            spans = _levels(registers.program, OUTPUTS + pdm, start, stop)
        for a, b, high in spans:
            a, b = max(a, first), min(b, last)
            if high and a < b and out and out[-1][1] == a:
                out[-1] = (out[-1][0], b)
            elif high and a < b:
                out.append((a, b))
    return out


def _levels(program: Program, channel: int, first: int, last: int) -> list[tuple[int, int, bool]]:
    return [(a, int(b), value >= HIGH_V) for a, b, _, value, _ in program.runs(channel, first, min(last, program.stop))]


def _stretches(history: History, last: int) -> Iterator[tuple[tuple[int, Registers], int]]:
    """Each entry with the sample at which the next one takes over."""
    ends = [k for k, _ in history[1:]] + [max(last, history[-1][0])]
    return ((entry, end) for entry, end in zip(history, ends, strict=True) if entry[0] < end)


def _runs(registers: Registers, output: int, start: int, stop: int) -> list[tuple[int, int, bool, float, bool, bool]]:
    """(from, to, enabled, V, waveforms silent, phase restarts) of one stretch of constant registers."""
    program = registers.program
    if program is None:
        return [(start, stop, True, 0.0, False, False)]
    out = []
    for a, b, enabled, value, restarts in program.runs(output, start, min(stop, program.stop)):
        resync = restarts or _in_resync(program, output, a)
        out.append((a, int(b), enabled, value, resync, restarts))
    if program.stop < stop:  # the server has zeroed amplitudes and tables, and enabled everything
        out.append((max(int(program.stop), start), stop, True, 0.0, True, False))
    return out


def _in_resync(program: Program, output: int, sample: int) -> bool:
    step = sample // program.samples_per_step % len(program.resync) if program.samples_per_step else 0
    return bool(program.samples_per_step and program.resync[step, output])


def _tones(
    channel: Output, value_v: float, turns: np.ndarray, factor: float, axis: int, start: int, stop: int, rate_hz: float
) -> Iterator[Burst]:
    """The bursts of one output while nothing changes; `turns` (4,) of the components' accumulators at its start."""
    constant = value_v + channel.offset_v
    if constant * factor:
        yield Burst(axis, start, stop, 0.0, constant * factor, np.pi / 2)
    for number, component in enumerate(channel.components):
        table = number == COMPONENTS
        if not (np.any(channel.table) if table else component.amplitude_v):
            continue
        for n, amplitude, phase in table_partials(channel.table) if table else partials(component.signal):
            frequency_hz = n * component.frequency_hz
            level = amplitude * factor * (1.0 if table else component.amplitude_v)
            if frequency_hz < rate_hz / 2:
                angle = 2 * np.pi * ((n * turns[number]) % 1.0) + n * component.phase_rad + phase
                yield Burst(axis, start, stop, frequency_hz, level, float(angle))


class _Ramp:
    """The factor of an output from the trigger on: up once, down once, in stairs."""

    def __init__(self, history: History, output: int, rate_hz: float) -> None:
        channel = history[-1][1].outputs[output]
        self._samples = channel.ramp_s * rate_hz if channel.ramp_enabled else 0.0
        commanded = [k for k, r in history if r.outputs[output].ramp_down]
        programs = [(k, r.program) for k, r in history if r.program is not None and np.any(r.program.ramp_down)]
        planned = [float(np.argmax(p.ramp_down)) * p.samples_per_step for _, p in programs]
        self._down = min([*commanded, *planned], default=np.inf)

    def stairs(self, first: int, last: int) -> Iterator[tuple[int, int, float]]:
        """(from, to, factor) covering samples first..last."""
        if not self._samples:
            yield first, last, 1.0
            return
        corners = [s + self._samples * k / RAMP_STAIRS for s in (0.0, self._down) for k in range(RAMP_STAIRS + 1)]
        edges = sorted({first, last, *(int(c) for c in corners if first < c < last)})
        for a, b in pairwise(edges):
            yield a, b, self._factor(0.5 * (a + b))

    def _factor(self, sample: float) -> float:
        up = min(sample / self._samples, 1.0)
        down = 1.0 - min(max((sample - self._down) / self._samples, 0.0), 1.0)
        return up * down


@lru_cache
def partials(signal: str) -> Partials:
    """(harmonic, amplitude, phase rad) of a waveform of unit amplitude; sine phases."""
    if signal == "SINE":
        return ((1, 1.0, 0.0),)
    odd = range(1, 2 * HARMONICS, 2)
    if signal == "SQUARE":
        return tuple((n, 4 / (np.pi * n), 0.0) for n in odd)
    if signal == "TRIANGLE":
        return tuple((n, 8 / (np.pi * n) ** 2 * (-1) ** (n // 2), 0.0) for n in odd)
    return tuple((n, 2 / (np.pi * n) * (-1) ** (n + 1), 0.0) for n in range(1, HARMONICS + 1))


def table_partials(table: NDArray[np.float64]) -> Partials:
    """The strongest harmonics (n, amplitude, phase) of a table that is played round and round; n = 0 is its mean."""
    spectrum = 2 * np.fft.rfft(table) / table.size
    spectrum[0] /= 2
    strongest = np.argsort(-np.abs(spectrum))[:HARMONICS]
    return tuple(
        (int(n), float(abs(spectrum[n])), float(np.angle(spectrum[n]) + np.pi / 2))
        for n in sorted(strongest)
        if abs(spectrum[n]) > NEGLIGIBLE
    )

"""Registers of an I/O card's outputs, and the sequence that the card steps through after the trigger."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

OUTPUTS = 2
COMPONENTS = 3
PDM_CHANNELS = 4
SEQUENCE_CHANNELS = OUTPUTS + PDM_CHANNELS
AWG_SAMPLES = 16384
AMPLITUDE_CODES = 65534
OFFSET_CODES = 32767
BASE_HZ = 125e6  # of the converters
FREQUENCY_STEP_HZ = BASE_HZ / 2**48
PHASE_STEPS = 2**48  # of a turn
SIGNALS = ("SINE", "SQUARE", "TRIANGLE", "SAWTOOTH")
NO_TABLE = np.zeros(AWG_SAMPLES)
PINS = ("7P", "7N", "6P", "6N", "5N", "4N", "3N", "2N")


@dataclass(frozen=True)
class Component:
    """One waveform of an output: Hz, rad, V (amplitude, unused in the fourth component, which plays the table)."""

    signal: str = "SINE"
    frequency_hz: float = 0.0
    phase_rad: float = 0.0
    amplitude_v: float = 0.0


@dataclass(frozen=True, eq=False)
class Output:
    """One DAC: three waveforms and the table player, offset V, and the ramp: length s, in use or not, going down."""

    components: tuple[Component, ...] = (Component(),) * (COMPONENTS + 1)
    offset_v: float = 0.0
    table: NDArray[np.float64] = field(default_factory=lambda: NO_TABLE)
    ramp_s: float = 0.0
    ramp_enabled: bool = False
    ramp_down: bool = False

    def with_component(self, number: int, **changes: float | str) -> Output:
        """One component changed."""
        changed = list(self.components)
        changed[number] = replace(changed[number], **changes)  # type: ignore[arg-type]
        return replace(self, components=tuple(changed))

    def silenced(self) -> Output:
        """What the server's stopTx leaves of it: no waveform, no table; the offset stays."""
        quiet = tuple(replace(c, amplitude_v=0.0) for c in self.components)
        return replace(self, components=quiet, table=NO_TABLE)


@dataclass(frozen=True, eq=False)
class Program:
    """A sequence as the card will step through it from the trigger on.

    values (steps, 6) V, enable (steps, 6) bool, resync (steps, 2) bool, ramp_down (steps,) bool; samples_per_step 0:
    it never leaves step 0; again_from: the step that comes again after the last one, and so for ever, None: it ends.
    """

    values: NDArray[np.float64]
    enable: NDArray[np.bool_]
    resync: NDArray[np.bool_]
    ramp_down: NDArray[np.bool_]
    samples_per_step: int
    again_from: int | None = None

    @property
    def ring(self) -> bool:
        """Whether no server ends it."""
        return self.again_from is not None

    @property
    def stop(self) -> float:
        """Sample at which the last step ends; inf: never."""
        if self.ring:
            return np.inf
        return len(self.values) * self.samples_per_step if self.samples_per_step else np.inf

    def runs(self, channel: int, first: int, last: float) -> list[tuple[int, float, bool, float, bool]]:
        """(from, to, enabled, V, phase restarts at its end) covering samples first..last of one channel."""
        if not len(self.values):
            return []
        if not self.samples_per_step:
            return [(first, last, bool(self.enable[0, channel]), float(self.values[0, channel]), False)]
        length = len(self.values) * self.samples_per_step
        runs = self._once(channel, first, min(last, length))
        if self.again_from is None:
            return runs
        begin = self.again_from * self.samples_per_step
        period = length - begin
        for k in range(max((first - begin) // period, 1), -int(-(last - begin) // period)):
            again = self._once(channel, max(first - k * period, begin), min(last - k * period, length))
            runs += [(a + k * period, b + k * period, enabled, value, ends) for a, b, enabled, value, ends in again]
        return runs

    def _once(self, channel: int, first: int, last: float) -> list[tuple[int, float, bool, float, bool]]:
        resync = self._resync(channel)
        starts = self._starts[channel]
        stops = np.append(starts[1:], len(self.values))
        out = []
        for a, b in zip(starts, stops, strict=True):
            start, stop = max(int(a) * self.samples_per_step, first), min(int(b) * self.samples_per_step, last)
            if start < stop:
                ends = bool(resync[a]) and stop == int(b) * self.samples_per_step
                out.append((start, stop, bool(self.enable[a, channel]), float(self.values[a, channel]), ends))
        return out

    def beginning_with(self, values: NDArray[np.float64]) -> Program:
        """The same with other values (6,) in step 0, enabled."""
        levels = self.values.copy()
        enable = self.enable.copy()
        levels[0] = values
        enable[0] = True
        return replace(self, values=levels, enable=enable)

    def _resync(self, channel: int) -> NDArray[np.bool_]:
        return self.resync[:, channel] if channel < OUTPUTS else np.zeros(len(self.values), dtype=np.bool_)

    @cached_property
    def _starts(self) -> list[NDArray[np.intp]]:
        """By channel, the steps at which something changes; cached, because each write to a register uses them."""
        return [self._starts_of(channel) for channel in range(self.values.shape[1])]

    def _starts_of(self, channel: int) -> NDArray[np.intp]:
        resync = self._resync(channel)
        new = np.ones(len(self.values), dtype=np.bool_)
        new[1:] = np.diff(self.values[:, channel]) != 0
        new[1:] |= np.diff(self.enable[:, channel]) | resync[1:] | resync[:-1]
        return np.flatnonzero(new)


@dataclass(frozen=True, eq=False)
class Registers:
    """Everything that decides what the card puts out; pins: those that are outputs and on; muted: instant reset."""

    outputs: tuple[Output, ...] = (Output(), Output())
    program: Program | None = None
    pins: frozenset[str] = frozenset()
    muted: bool = False

    def with_output(self, number: int, output: Output) -> Registers:
        """One output changed."""
        changed = list(self.outputs)
        changed[number] = output
        return replace(self, outputs=tuple(changed))

    def silenced(self) -> Registers:
        """After stopTx: no waveforms, no sequence; offsets and pins stay."""
        return replace(self, outputs=tuple(o.silenced() for o in self.outputs), program=None)

"""The sample-exact timeline that the I/O card plays and records.

A shot is one contiguous run of samples: TX window, switch window, RX window (paper, section "Measurement Sequence").
Sample k is the instant k / rate after the trigger, for outputs, lines and inputs alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SampleClock:
    """The converter clock and its decimation; the paper's card runs at 125 MHz / 2048."""

    base_frequency_hz: float
    decimation: int

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.base_frequency_hz / self.decimation


class DigitalLine(StrEnum):
    """Digital lines that the card switches sample-exactly.  Low is the safe level of each."""

    PA_GATE = "pa_gate"
    """High: the power amplifier may put out power (if it is also enabled and not muted)."""

    RX_CONNECT = "rx_connect"
    """High: the Tx/Rx switch connects the coils to the receiver."""


@dataclass(frozen=True)
class Burst:
    """A gated sine on one analog output.

    In volts at the DAC: `amplitude_v * sin(2 pi frequency_hz (t - start) + phase_rad)` for samples
    `start_sample <= k < stop_sample`, zero elsewhere.  Frequency 0 makes a constant, `amplitude_v * sin(phase_rad)`.
    """

    output: int
    start_sample: int
    stop_sample: int
    frequency_hz: float
    amplitude_v: float
    phase_rad: float = 0.0


@dataclass(frozen=True)
class LineLevel:
    """`line` is high for samples `start_sample <= k < stop_sample`; a line is low wherever no entry raises it."""

    line: DigitalLine
    start_sample: int
    stop_sample: int


@dataclass(frozen=True)
class Timeline:
    """Everything the card plays and records in one shot.

    After the last sample, and after any stop, every output is zero and every line low: a card that cannot promise
    that must not be driven.
    """

    clock: SampleClock
    tx_samples: int
    switch_samples: int
    rx_samples: int
    bursts: tuple[Burst, ...] = ()
    lines: tuple[LineLevel, ...] = ()

    def __post_init__(self) -> None:
        if min(self.tx_samples, self.switch_samples) < 0 or self.rx_samples < 1:
            raise ValueError("a timeline needs tx >= 0, switch >= 0 and rx >= 1 samples")
        parts: tuple[Burst | LineLevel, ...] = (*self.bursts, *self.lines)
        for part in parts:
            if not 0 <= part.start_sample < part.stop_sample <= self.total_samples:
                raise ValueError(f"{part} lies outside samples 0..{self.total_samples}")

    @property
    def total_samples(self) -> int:
        """Samples in the whole frame."""
        return self.tx_samples + self.switch_samples + self.rx_samples

    @property
    def rx_start(self) -> int:
        """Index of the first RX sample, the time zero of every fit."""
        return self.tx_samples + self.switch_samples

    @property
    def duration_s(self) -> float:
        """Length of the whole frame in seconds."""
        return self.total_samples / self.clock.rate_hz

    def is_high(self, line: DigitalLine, sample: int) -> bool:
        """Level of `line` at `sample`."""
        return any(e.line is line and e.start_sample <= sample < e.stop_sample for e in self.lines)

    def output_volts(self, output: int, start: int, stop: int, per_sample: int = 1) -> NDArray[np.float64]:
        """What one output plays in samples `start..stop`, so many points each: (points,) float64, V."""
        volts = np.zeros((stop - start) * per_sample)
        for b in self.bursts:
            first, last = max(b.start_sample, start), min(b.stop_sample, stop)
            if b.output == output and first < last:
                points = np.arange((first - b.start_sample) * per_sample, (last - b.start_sample) * per_sample)
                turn = 2 * np.pi * b.frequency_hz * points / (self.clock.rate_hz * per_sample) + b.phase_rad
                volts[(first - start) * per_sample : (last - start) * per_sample] += b.amplitude_v * np.sin(turn)
        return volts

    def loudest_v(self, output: int) -> float:
        """Largest sum of the amplitudes of bursts that sound together on one output, V; 0 if none does."""
        bursts = [b for b in self.bursts if b.output == output]
        steps = [(b.start_sample, abs(b.amplitude_v)) for b in bursts]
        steps += [(b.stop_sample, -abs(b.amplitude_v)) for b in bursts]
        if not all(np.isfinite(change) for _, change in steps):
            return float("nan")
        steps.sort()  # at one sample what ends comes first: its change is negative
        return max((float(s) for s in np.cumsum([change for _, change in steps])), default=0.0)

"""Lock-in by least squares: the complex amplitude of a tone of known frequency, and how well it is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.calibration
SEGMENTS = LIMITS.segments
LEAST_PERIODS = LIMITS.segment_periods


@dataclass(frozen=True)
class Phasors:
    """value: (channel,) complex, x(t) = Im(value exp(2 pi i f t)); std: (channel,) of the real and of the imaginary
    part; dof: degrees of freedom behind std."""

    value: NDArray[np.complex128]
    std: NDArray[np.float64]
    dof: int


def segment_length(samples: int, frequency_hz: float, rate_hz: float, segments: int = SEGMENTS) -> int:
    """Samples of a segment of so many samples.  Raises ValueError if it has less than one period of the tone."""
    length = samples // segments
    if length * frequency_hz / rate_hz < LEAST_PERIODS or length < LIMITS.segment_samples:
        raise ValueError(f"{segments} segments of {length} samples are too short for {frequency_hz:g} Hz")
    return length


def segment_phasors(
    samples: NDArray[np.float64], frequency_hz: float, rate_hz: float, first_sample: int = 0, segments: int = SEGMENTS
) -> NDArray[np.complex128]:
    """Complex amplitudes in successive segments of (channel, n) samples: (segment, channel).

    Time zero is `first_sample` samples before the first of them.  A constant is fitted together with the tone, so
    segments need not hold whole periods.  Raises ValueError if a segment has less than one period.
    """
    length = segment_length(samples.shape[1], frequency_hz, rate_hz, segments)
    rows = []
    for k in range(segments):
        part = samples[:, k * length : (k + 1) * length]
        turn = 2 * np.pi * frequency_hz * (np.arange(length) + k * length + first_sample) / rate_hz
        design = np.stack([np.sin(turn), np.cos(turn), np.ones(length)], axis=1)
        found = np.linalg.lstsq(design, part.T, rcond=None)[0]
        rows.append(found[0] + 1j * found[1])
    return np.array(rows)


def combine(segments: NDArray[np.complex128]) -> Phasors:
    """Mean of equally good segments (n, channel) with its standard deviation, from their scatter; n >= 2."""
    n = len(segments)
    value = segments.mean(axis=0)
    dof = 2 * (n - 1)
    spread = np.sum(np.abs(segments - value) ** 2, axis=0) / dof
    return Phasors(value, np.sqrt(spread / n), dof)


def frequency_offset(segments: NDArray[np.complex128], segment_s: float) -> tuple[float, float]:
    """How far a tone is above the frequency of its segments' phasors (n, channel), Hz, and its standard deviation.

    By a line through the phase of the loudest channel; n >= 3.
    """
    loudest = segments[:, int(np.argmax(np.sum(np.abs(segments) ** 2, axis=0)))]
    phase, times_s = np.unwrap(np.angle(loudest)), segment_s * np.arange(len(loudest))
    around = times_s - times_s.mean()
    slope = float(around @ phase / (around @ around))
    left = phase - phase.mean() - slope * around
    std = float(np.sqrt(left @ left / (len(phase) - 2) / (around @ around)))
    return slope / (2 * np.pi), std / (2 * np.pi)

"""What rings in a shot, also where it is too weak for a fit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.spectral_lines import is_mains, peak_shift, periodogram
from platform_daemon.features.fit.measurement import open_voltages
from platform_daemon.features.procedures.schema import RingingLine

RINGING_SPAN = 1.3
"""The line is looked for from the expected frequency divided by this to its multiple."""
_BEGINNINGS_S = (0.1, 0.4, 1.6)  # of what decays soon, and of what is weak
_FEWEST_PERIODS = 8
_KAISER_BETA = 8.0  # side lobes below 1e-6 of the power
_SIGNIFICANT = 40.0  # the sum over three channels exceeds it in noise by a chance of 4e-15 per bin
_MAINS_OFF = 2e-3  # relative
_MOST_MISSED_HZ = 2.0  # what leaks further is no peak there


def ringing_line(path: Path, expected_hz: float) -> RingingLine | None:
    """The strongest line near the expected frequency in the only frame of a shot's file; None: nothing rings.

    Lines at multiples of a mains frequency are left out.  Raises RecordingError.
    """
    return line_in(open_voltages(path).signal(0).record, expected_hz)


def line_in(record: RingDownRecord, expected_hz: float) -> RingingLine | None:
    """See `ringing_line`."""
    samples, rate_hz = record.samples, record.sampling_rate_hz
    found = (_line(samples[:, : int(s * rate_hz)], rate_hz, expected_hz) for s in _BEGINNINGS_S)
    best = max((line for line in found if line is not None), key=lambda line: line.significance, default=None)
    if best is None:
        return None
    shortest = min(samples.shape[1], int(_BEGINNINGS_S[0] * rate_hz))
    return best.model_copy(update={"snr": _snr(samples[:, :shortest], rate_hz, best.frequency_hz)})


def _line(samples: Array, rate_hz: float, expected_hz: float) -> RingingLine | None:
    n = samples.shape[1]
    if n * expected_hz / rate_hz < _FEWEST_PERIODS:
        return None
    window = np.kaiser(n, _KAISER_BETA)
    size = 2 * n  # so that the peak is found between bins
    power = periodogram(samples - samples.mean(axis=1, keepdims=True), window, size)
    frequency = np.arange(power.shape[1]) * rate_hz / size
    near = (frequency > expected_hz / RINGING_SPAN) & (frequency < expected_hz * RINGING_SPAN)
    beside = (frequency > expected_hz / 4) & (frequency < expected_hz * 4)
    level = np.maximum(np.median(power[:, beside], axis=1) / math.log(2), 1e-300)
    missed_hz = min(rate_hz / n, _MOST_MISSED_HZ)
    own = [not is_mains(f, relative=_MAINS_OFF, missed_hz=missed_hz) for f in frequency[near]]
    relative = (power / level[:, None]).sum(axis=0)
    candidates = np.flatnonzero(near)[own]
    if candidates.size == 0:
        return None
    peak = int(candidates[np.argmax(relative[candidates])])
    is_local = relative[peak] == np.max(relative[peak - 1 : peak + 2])
    if relative[peak] < _SIGNIFICANT or not is_local:
        return None
    return RingingLine(
        frequency_hz=(peak + peak_shift(relative, peak)) * rate_hz / size,
        significance=float(relative[peak]),
        snr=0.0,
    )


def _snr(beginning: Array, rate_hz: float, frequency_hz: float) -> float:
    """Amplitude of the line over the noise of one sample, (c, n), in the channel where that is most; white noise."""
    n = beginning.shape[1]
    window = np.kaiser(n, _KAISER_BETA)
    centred = beginning - beginning.mean(axis=1, keepdims=True)
    turn = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(n))
    amplitude = 2 * np.abs((centred * window) @ turn) / float(window.sum())
    power = periodogram(centred, window)
    high = power[:, int(4 * frequency_hz * n / rate_hz) :]
    noise = np.sqrt(np.median(high, axis=1) / math.log(2))
    return float(np.max(amplitude / np.maximum(noise, 1e-300)))

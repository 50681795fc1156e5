"""Which samples a fit uses: the paper's N50 and D30 datasets, or any number of seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

from .crest import crest_factor

LIMITS = THRESHOLDS.screening
N50_SECONDS = LIMITS.n50_s

Window = Literal["n50", "d30"] | float


@dataclass(frozen=True, kw_only=True)
class SampleRange:
    """Samples first .. last-1 of a record, and what had to be said about them."""

    first: int
    last: int
    notes: tuple[str, ...] = ()


def check_window(window: Window) -> None:
    """ValueError unless the window is "n50", "d30" or a positive finite number of seconds."""
    if isinstance(window, str):
        if window not in ("n50", "d30"):
            raise ValueError(f"window must be 'n50', 'd30' or seconds, not {window!r}")
    elif isinstance(window, bool) or not (math.isfinite(window) and window > 0.0):
        raise ValueError(f"a window in seconds must be positive and finite, not {window!r}")


def select_window(record: RingDownRecord, window: Window, frequency_hz: float, noise_sd: Array) -> SampleRange:
    """Resolve a window to samples; a record that is too short for it is used whole, with a note.

    Args:
        record: the record.
        window: "n50", "d30" or seconds from time 0.
        frequency_hz: oscillation frequency, sets the averaging length of the envelope.
        noise_sd: (channels,), subtracted from the envelope.
    """
    if window == "d30":
        return _decay_window(record, frequency_hz, noise_sd)
    seconds = N50_SECONDS if isinstance(window, str) else float(window)
    wanted = round(seconds * record.sampling_rate_hz)
    last = min(wanted, record.end)
    notes: tuple[str, ...] = ()
    if last < wanted:
        notes = (f"record ends after {last * record.dt_s:.4g} s, before {seconds:g} s: used whole",)
    return SampleRange(first=record.valid_from, last=last, notes=notes)


def _decay_window(record: RingDownRecord, frequency_hz: float, noise_sd: Array) -> SampleRange:
    """D30: up to the point where the peaks of the strongest channel have decayed to 30 % of its maximum.

    Its rms in blocks of periods says when, for noise spoils that least; but the shape of the waveform changes with the
    amplitude, and with it what the peaks are in units of the rms.
    """
    y = record.valid
    channel = int(np.argmax(np.sum(y[:, : max(1, y.shape[1] // LIMITS.d30_first_divisor)] ** 2, axis=1)))
    for periods in LIMITS.d30_block_periods:
        length = max(LIMITS.d30_block_samples, round(periods * record.sampling_rate_hz / frequency_hz))
        envelope = _envelope(y[channel], length, float(noise_sd[channel]))
        if envelope.size == 0:
            break
        # Average over more periods until noise cannot fake a crossing.
        if envelope[0] > LIMITS.d30_over_noise * noise_sd[channel] / math.sqrt(length):
            break
    level = _level(y[channel], envelope, length, record.sampling_rate_hz, frequency_hz) if envelope.size else 0.0
    below = np.flatnonzero(envelope < level)
    if below.size == 0:
        return SampleRange(
            first=record.valid_from,
            last=record.end,
            notes=("record ends before the signal decayed to 30 %: used whole",),
        )
    crossing = _crossing(envelope, int(below[0]), level)
    centre = record.valid_from + (crossing + 0.5) * length
    return SampleRange(first=record.valid_from, last=min(record.end, int(centre)))


def _envelope(signal: Array, length: int, sd: float) -> Array:
    """Amplitude of consecutive blocks of `length` samples, (blocks,), freed from noise power."""
    blocks = signal[: signal.size // length * length].reshape(-1, length)
    return np.sqrt(np.maximum(2.0 * (blocks.var(axis=1) - sd**2), 0.0))


def _level(signal: Array, envelope: Array, length: int, rate_hz: float, frequency_hz: float) -> float:
    """The envelope where the peaks are at 30 % of the largest."""
    largest = int(np.argmax(envelope))
    level = LIMITS.d30_share * float(envelope[largest])
    below = np.flatnonzero(envelope[largest:] < level)
    there = largest + int(below[0]) if below.size else envelope.size - 1
    first, last = (
        crest_factor(signal, centre=int((k + 0.5) * length), rate_hz=rate_hz, frequency_hz=frequency_hz)
        for k in (largest, there)
    )
    return level if first is None or last is None else level * first / last


def _crossing(envelope: Array, index: int, level: float) -> float:
    """Fractional block where the envelope crosses a level before `index`."""
    if index == 0 or envelope[index - 1] <= envelope[index]:
        return float(index)
    return index - 1 + float((envelope[index - 1] - level) / (envelope[index - 1] - envelope[index]))

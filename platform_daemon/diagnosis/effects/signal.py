"""Effects of the receive side that act on the whole signal: gains, delays, poles, crosstalk, compression.

Each column is the first-order change of the channels; `undo` takes the effect out of the data exactly, or to an order
far below the noise, so that refits with an effect are fits of the declared model to freed data.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from platform_daemon.estimation.arrays import Array

from ..look import Look
from ..shots import Shot
from .base import Candidate, Detail, Effect

_AXES = "xyz"
_CAL_2F, _TURN, _AMPLITUDE = "calibrate_2f", "turn_90_deg", "second_amplitude"
GAIN = Effect("channel_gain", "1", 0, (_TURN, _CAL_2F), "calibration error; L/R or AC-coupling pole")
DELAY = Effect("channel_delay", "s", 0, (_CAL_2F,), "filter delay that differs between channels")
LOW_PASS = Effect("receive_lowpass", "s", 1, (_CAL_2F,), "coil and cable capacitance, amplifier bandwidth")
COMPRESSION = Effect("receiver_compression", "1/V^2", 0, (_AMPLITUDE,), "amplifier near its limit")
CROSSTALK = Effect("crosstalk", "1", 0, (_TURN, _CAL_2F), "coupling of coils and channels")

# Central difference of order 8: exact to 1e-9 at a tenth of the sampling rate's twentieth.
_STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def derivative(samples: Array, rate_hz: float) -> Array:
    """Time derivative of (channels, n); the four samples at either end repeat their neighbours' value."""
    inner = np.stack([np.convolve(row, _STENCIL[::-1], mode="valid") for row in samples]) * rate_hz
    return np.pad(inner, ((0, 0), (4, 4)), mode="edge")


def signal_candidates(channels: int, has_sensitivity: bool) -> list[Candidate]:
    """Everything that can happen to so many channels."""
    found = [Candidate(GAIN, Detail(axis=_AXES[c]), columns=partial(_gain, c), undo=partial(_undo_gain, c))
             for c in range(channels)]  # fmt: skip
    if channels == 1:
        return found
    found += [Candidate(DELAY, Detail(axis=_AXES[c]), columns=partial(_delay, c), undo=partial(_undo_delay, c))
              for c in range(channels)]  # fmt: skip
    found += [
        Candidate(CROSSTALK, Detail(start=_AXES[a], end=_AXES[b]), columns=partial(_mix, a, b), undo=partial(_undo_mix, a, b))
        for a in range(channels) for b in range(channels) if a != b
    ]  # fmt: skip
    return found


def _on(channel: int, row: Array, channels: int) -> Array:
    """One column that is `row` on one channel, (1, channels, m)."""
    out = np.zeros((1, channels, row.size))
    out[0, channel] = row
    return out


def _gain(channel: int, look: Look) -> Array:
    return _on(channel, look.signal[channel], look.signal.shape[0])


def _undo_gain(channel: int, samples: Array, shot: Shot, strength: Array) -> Array:
    out = samples.copy()
    out[channel] /= 1.0 + strength[0]
    return out


def _delay(channel: int, look: Look) -> Array:
    return _on(channel, -look.slope[channel], look.signal.shape[0])


def _undo_delay(channel: int, samples: Array, shot: Shot, strength: Array) -> Array:
    """y(t + delay) by Taylor's series to the fifth order."""
    out = samples.copy()
    term = samples[channel : channel + 1]
    for k in range(1, 6):
        term = derivative(term, shot.record.sampling_rate_hz) * (strength[0] / k)
        out[channel] += term[0]
    return out


def _mix(source: int, target: int, look: Look) -> Array:
    return _on(target, look.signal[source], look.signal.shape[0])


def _undo_mix(source: int, target: int, samples: Array, shot: Shot, strength: Array) -> Array:
    out = samples.copy()
    out[target] -= strength[0] * samples[source]
    return out

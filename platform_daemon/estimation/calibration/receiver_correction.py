"""Receiver effects of an adopted model, undone in the calibrated samples before a fit.

The digitiser's channels are u = -P dm/dt (eq:u(t,p,R)), the receive chain's response taken out. Every effect is undone
in them, in the order in which it was adopted, as if it acted alone; products of two are left. `s` is the strength, v
what the channel would be without the effect:

    channel_gain           v = u / (1 + s)
      of odd or even harmonics: v = u - s u_part / (1 + s),
                             u_even = u/2 + (u(t - T/2) + u(t + T/2))/4, u_odd = u - u_even
    channel_delay          v(t) = u(t + s), quintic splines
    receive_lowpass        v = u + s du/dt, exact for one pole
    receiver_compression   u = v (1 - s v^2), solved by fixed-point steps
    crosstalk              v[to] = u[to] - s u[from]
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivers.calibration import ReceiverEffect
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.calibration

CORRECTABLE = ("channel_gain", "channel_delay", "receive_lowpass", "receiver_compression", "crosstalk")
_AXES = "xyz"
# Central difference of order 8.
_STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def correct_receiver_effects(
    record: RingDownRecord, sensitivity: Array, effects: Sequence[ReceiverEffect]
) -> RingDownRecord:
    """A dm/dt record (3, n) without these effects; samples near the ends that they reach beyond are no longer valid."""
    if not effects:
        return record
    u = -sensitivity @ record.samples
    reach = 0
    for effect in effects:
        u, lost = _without_effect(u, record.sampling_rate_hz, effect)
        reach += lost
    return replace(
        record,
        samples=-np.linalg.inv(sensitivity) @ u,
        valid_from=min(record.valid_from + reach, record.end),
        valid_to=max(record.end - reach, min(record.valid_from + reach, record.end)),
    )


def _without_effect(u: Array, rate_hz: float, effect: ReceiverEffect) -> tuple[Array, int]:
    """The channels without one effect, and how many samples at either end are spoilt."""
    s = effect.strength
    out = u.copy()
    reach = 0
    if effect.id == "crosstalk":
        assert effect.source is not None
        assert effect.target is not None
        out[_AXES.index(effect.target)] -= s * u[_AXES.index(effect.source)]
        return out, 0
    for c in range(len(u)) if effect.axis is None else [_AXES.index(effect.axis)]:
        out[c], reach = _corrected_channel(u[c], rate_hz, effect)
    return out, reach


def _corrected_channel(u: Array, rate_hz: float, effect: ReceiverEffect) -> tuple[Array, int]:
    s = effect.strength
    if effect.id == "channel_gain" and effect.even is not None:
        assert effect.fundamental_hz is not None
        part, reach = _harmonics(u, 0.5 * rate_hz / effect.fundamental_hz, even=effect.even)
        return u - s / (1.0 + s) * part, reach
    if effect.id == "channel_gain":
        return u / (1.0 + s), 0
    if effect.id == "channel_delay":
        from scipy.ndimage import shift  # here, because every fit imports this module and few need it

        moved = shift(u, -s * rate_hz, order=5, mode="nearest")
        return moved, LIMITS.spline_reach_samples + math.ceil(abs(s) * rate_hz)
    if effect.id == "receive_lowpass":
        slope = np.pad(np.correlate(u, _STENCIL, mode="valid") * rate_hz, 4, mode="edge")
        return u + s * slope, 4
    if effect.id == "receiver_compression":
        v = u
        for _ in range(LIMITS.compression_steps):
            v = u / (1.0 - s * v**2)
        return v, 0
    raise ValueError(f"{effect.id} cannot be undone: {', '.join(CORRECTABLE)} can")


def _harmonics(u: Array, half_period: float, *, even: bool) -> tuple[Array, int]:
    """The even or the odd harmonics of (n,); half_period: of the fundamental, in samples."""
    at = np.arange(u.size)
    both = np.interp(at - half_period, at, u) + np.interp(at + half_period, at, u)
    found = 0.5 * u + 0.25 * both
    return (found if even else u - found), math.ceil(half_period)

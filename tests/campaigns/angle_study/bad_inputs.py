"""Files that are no ring-down of one angle, each bad in one way."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from tests.campaigns.angle_study.motion import Array, reading, vector
from tests.campaigns.angle_study.record import write_angle

_RATE_HZ, _DURATION_S = 500.0, 20.0
_QUANTUM, _WHITE = math.pi / 2**12, 4e-4
_SWING = {"f_hz": 1.3, "lambda": 0.04, "phi": 0.9, "v": 0.3}
_Made = tuple[Array, Array]  # time, angle


def _read(angle: Array, seed: int = 1) -> Array:
    noisy = angle + _WHITE * np.random.default_rng(seed).standard_normal(angle.shape)
    return np.asarray(_QUANTUM * np.round(noisy / _QUANTUM))


def _times(duration_s: float = _DURATION_S) -> Array:
    return np.arange(int(duration_s * _RATE_HZ)) / _RATE_HZ


def _good(duration_s: float = _DURATION_S) -> _Made:
    return _times(duration_s), _read(reading(_times(duration_s), vector(_SWING)))


def _constant() -> _Made:
    return _times(), np.full(_times().size, 0.3)


def _one_period() -> _Made:
    return _good(1.0 / _SWING["f_hz"])


def _clock(change: Callable[[Array], Array]) -> Callable[[], _Made]:
    def make() -> _Made:
        time, angle = _good()
        return change(time.copy()), angle

    return make


def _backwards(time: Array) -> Array:
    time[time.size // 2 :] -= 3.0
    return time


def _repeated(time: Array) -> Array:
    middle = time.size // 2
    time[middle : middle + 200] = time[middle]
    return time


def _twice(time: Array) -> Array:
    return np.repeat(time[::2], 2)[: time.size]


def _mixed(time: Array) -> Array:
    step = np.where(np.arange(time.size) < time.size // 2, 1.0, 4.0) / _RATE_HZ
    return np.concatenate([[0.0], np.cumsum(step)[:-1]])


def _degrees() -> _Made:
    time, angle = _good()
    return time, np.degrees(angle)


def _not_finite() -> _Made:
    time, angle = _good()
    angle[4000:4010] = np.nan
    return time, angle


def _two_channels() -> _Made:
    time, angle = _good()
    return time, np.stack([angle, 0.1 * angle])


def _rest() -> _Made:
    return _times(), _read(np.full(_times().size, 0.02))


def _driven(hz: float, start: tuple[float, float], damping: float) -> Callable[[], _Made]:
    """A pendulum under a steady torque from outside."""

    def make() -> _Made:
        w = 2.0 * math.pi * _SWING["f_hz"]
        done = solve_ivp(
            lambda t, y: (
                y[1],
                -w * w * math.sin(y[0]) - 2.0 * damping * y[1] + 0.06 * w * w * math.cos(2.0 * math.pi * hz * t),
            ),
            (0.0, 60.0 + _DURATION_S), start, "DOP853", t_eval=60.0 + _times(), rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        return _times(), _read(done.y[0])

    return make


def _beat() -> _Made:
    """Driven beside its frequency, from rest: what is free has not died yet."""
    w = 2.0 * math.pi * _SWING["f_hz"]
    push = 2.0 * math.pi * 1.12 * _SWING["f_hz"]
    done = solve_ivp(
        lambda t, y: (y[1], -w * w * math.sin(y[0]) - 0.02 * y[1] + 0.05 * w * w * math.cos(push * t)),
        (0.0, _DURATION_S), (0.0, 0.0), "DOP853", t_eval=_times(), rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    return _times(), _read(done.y[0])


BAD: dict[str, Callable[[], _Made]] = {
    "constant": _constant,
    "one-period": _one_period,
    "time-runs-back": _clock(_backwards),
    "time-stands-still": _clock(_repeated),
    "time-twice-each": _clock(_twice),
    "degrees-as-rad": _degrees,
    "not-finite": _not_finite,
    "two-channels": _two_channels,
    "mixed-rates": _clock(_mixed),
    "rest-without-motion": _rest,
    "driven-steady": _driven(1.1, (0.1, 0.0), 0.3),
    "driven-at-resonance": _driven(1.25, (0.1, 0.0), 0.3),
    "driven-beat": _beat,
}


def write_bad(name: str, folder: Path) -> Path:
    """One of BAD as a file."""
    time, angle = BAD[name]()
    return write_angle(folder / f"{name}.h5", time, angle)

"""Least squares by scipy on the trajectory: visibility of an effect, and the best that can be predicted."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from tests.campaigns.angle_study.motion import NAMES, PLACE, Array, reading

DECLARED = ("f_hz", "lambda", "phi", "v", "offset")
_SCALES = {  # a change that is plainly seen, by (amplitude, w, duration)
    "f_hz": lambda a, w, d: 0.1 / d,
    "lambda": lambda a, w, d: 0.1 / d,
    "phi": lambda a, w, d: 0.1 * a,
    "v": lambda a, w, d: 0.1 * a * w,
    "offset": lambda a, w, d: 0.1 * a,
    "coulomb": lambda a, w, d: 0.1 * a * w / d,
    "excess": lambda a, w, d: 0.1,
    "speed": lambda a, w, d: 0.1 * a * w,
    "quadratic": lambda a, w, d: 0.1 / (a * w * d),
    "angle_damping": lambda a, w, d: 0.1 / (a * a * d),
    "cubic": lambda a, w, d: 0.1 / (a * a * w * d),
    "bias": lambda a, w, d: 0.01 * a * w * w,
    "drift": lambda a, w, d: 0.1 / (w * d),
    "drift_tau": lambda a, w, d: 0.1 * d,
    "kick": lambda a, w, d: 0.1 * a * w,
    "kick_s": lambda a, w, d: 0.1 / w,
    "zero": lambda a, w, d: 0.1 * a,
    "zero_tau": lambda a, w, d: 0.1 * d,
    "mode_cos": lambda a, w, d: 0.01 * a,
    "mode_sin": lambda a, w, d: 0.01 * a,
    "mode_hz": lambda a, w, d: 0.1 / d,
    "mode_tau": lambda a, w, d: 0.1 * d,
}
_SMALL = 1e-5
_FAR = 0.2  # of the amplitude
_LOST = 1e3  # of a trajectory that leads nowhere
_SHARES = (0.1, 0.25, 0.5, 1.0)


def fitted(times: Array, angle: Array, begin: Array, free: Sequence[str], sd: float) -> Array:
    """Parameters by least squares from these on; over ever longer parts where the phase may be off by turns."""
    duration, w = float(times[-1]), 2.0 * math.pi * begin[PLACE["f_hz"]]
    amplitude = 0.5 * float(np.ptp(angle))
    scales = np.array([_SCALES[name](amplitude, w, duration) for name in free])
    scales *= np.where(np.array(free) == "drift", _drift_unit(begin, duration), 1.0)
    places = [PLACE[name] for name in free]
    p = begin.copy()
    far = rms(reading(times, p) - angle) > _FAR * amplitude
    for share in _SHARES if far else _SHARES[-1:]:
        n = max(32, round(share * times.size))
        p[places] = _solved(times[:n], angle[:n], p, places, scales, sd)
    return p


def _drift_unit(p: Array, duration: float) -> float:
    """A drift is told per second or in all."""
    return 1.0 if p[PLACE["drift_tau"]] > 0.0 else 1.0 / duration


def _solved(times: Array, angle: Array, start: Array, places: list[int], scales: Array, sd: float) -> Array:
    def at(u: Array) -> Array:
        p = start.copy()
        p[places] = start[places] + scales * u
        return p

    def residual(u: Array) -> Array:
        seen = reading(times, at(u)) if _usable(at(u)) else np.full(times.size, np.nan)
        return np.asarray(np.where(np.isfinite(seen), seen - angle, _LOST) / sd)

    def slopes(u: Array) -> Array:
        found, here = np.empty((times.size, u.size)), residual(u)
        for j in range(u.size):
            step = np.zeros(u.size)
            step[j] = _SMALL
            found[:, j] = (residual(u + step) - here) / _SMALL
        return found

    done = least_squares(
        residual, np.zeros(len(places)), slopes, method="trf", x_scale="jac", xtol=1e-12, ftol=1e-7, gtol=1e-12,
        max_nfev=40,
    )  # fmt: skip
    return np.asarray(at(done.x)[places])


def _usable(p: Array) -> bool:
    return bool(p[PLACE["f_hz"]] > 0.0 and all(p[PLACE[n]] >= 0.0 for n in NAMES if n.endswith("_tau")))


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def held_out_error(times: Array, angle: Array, begin: Array, free: Sequence[str], sd: float, split: float) -> float:
    """Rms error over rms of the data, of the end as the true model foretells it from before the share `split`."""
    first = times - times[0] < split * (times[-1] - times[0])
    p = fitted(times[first], angle[first], begin, free, sd)
    left = (reading(times, p) - angle)[~first]
    return rms(left) / rms(angle[~first] - p[PLACE["offset"]])

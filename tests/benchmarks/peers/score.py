"""One uninterrupted simulation by scipy, its start fitted to the training part, and the error of the rest.

nRMSE: rms of the error over the standard deviation of the signal, both over the scored part. Of an angle the offset of
the zero is fitted with the start; of dm/dt the gains of d(sin phi)/dt and d(cos phi)/dt in every channel are.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import ODEintWarning, odeint
from scipy.optimize import least_squares

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.columns import Model
from tests.benchmarks.peers.datasets import Record, Task
from tests.benchmarks.peers.states import states_of

_FIT_POINTS = 6000  # samples of the training part at most, evenly spaced
_SCORE_POINTS = 60000
_RTOL, _ATOL = 1e-10, 1e-11
STEP = 1e-5  # relative, of numerical derivatives
_FAILED = 1e3  # residual of a motion that cannot be followed


@dataclass(frozen=True)
class Motion:
    """Angle and velocity at some times, (n,)."""

    phi: Array
    v: Array


@dataclass(frozen=True)
class Score:
    """nRMSE of the part from which the start comes, and held out."""

    train: float
    held_out: float


def simulate(model: Model, phi: float, v: float, time_s: Array) -> Motion:
    """From the state at time_s[0]; NaN where the motion cannot be followed."""
    torque, gaps = model.torque, model.gaps
    solve: Any = odeint  # its stubs know no full_output with a list of tolerances

    def rates(y: Array, t: float) -> tuple[float, float]:
        p, q = float(y[0]), float(y[1])
        return q, torque(p, q, t)

    true_s = time_s + sum((lost * (time_s >= at) for at, lost in gaps), np.zeros_like(time_s))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", ODEintWarning)
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            y, info = solve(
                rates, [phi, v], true_s, rtol=_RTOL, atol=[_ATOL, _ATOL * model.speed], mxstep=20000, full_output=True
            )
        except (OverflowError, ValueError, ZeroDivisionError):
            return Motion(np.full_like(time_s, math.nan), np.full_like(time_s, math.nan))
    bad = info["message"] != "Integration successful." or not np.isfinite(y).all() or np.abs(y[:, 0]).max() > 50.0
    return Motion(*(np.full((2, time_s.size), math.nan) if bad else y.T))


def observed(record: Record, motion: Motion, learnt: slice, every: slice) -> Array:
    """The record's channels as this motion makes them; what is linear is fitted to `learnt`, of the samples `every`."""
    signal = record.signal[:, every]
    if record.quantity == "angle":
        return (motion.phi + float(np.mean((signal[0] - motion.phi)[learnt])))[None]
    basis = np.stack([np.cos(motion.phi) * motion.v, -np.sin(motion.phi) * motion.v])
    gram = basis[:, learnt] @ basis[:, learnt].T
    gains = np.linalg.solve(gram, basis[:, learnt] @ signal[:, learnt].T)
    return np.asarray(gains.T @ basis)


def first_state(record: Record) -> tuple[float, float]:
    """Angle and velocity at the first sample, roughly."""
    s = states_of(record)
    if record.quantity == "angle":
        return float(s.phi[0] - np.median(s.phi)), float(s.v[0])
    # The states begin after the filters have settled: back by the undamped motion.
    back = s.w * float(s.time_s[0] - record.time_s[0])
    phi, v = float(s.phi[0]), float(s.v[0])
    return phi * math.cos(back) - v / s.w * math.sin(back), v * math.cos(back) + phi * s.w * math.sin(back)


def residual(record: Record, model: Model, state: Array, samples: int) -> Array:
    """Of the first samples, flat: in rad, or of dm/dt over its standard deviation."""
    every = slice(0, samples, max(1, samples // _FIT_POINTS))
    motion = simulate(model, float(state[0]), float(state[1]), record.time_s[every])
    signal = record.signal[:, every]
    if not np.isfinite(motion.phi).all():
        return np.full(signal.size, _FAILED)
    made = observed(record, motion, slice(None), every)
    unit = 1.0 if record.quantity == "angle" else float(signal.std())
    return np.asarray((signal - made).ravel() / unit)


def shares(record: Record, w: float) -> list[float]:
    """Of a record: 4 periods, four times as many and so on, at last all, so that no fit slips by a whole turn."""
    periods = w * float(record.time_s[-1] - record.time_s[0]) / (2.0 * math.pi)
    count = max(0, math.ceil(math.log(max(periods, 4.0) / 4.0, 4.0)))
    return [*(4.0 ** (k + 1) / periods for k in range(count)), 1.0]


def fitted_start(record: Record, model: Model, samples: int) -> tuple[float, float]:
    """Angle and velocity at the first sample, from so many samples; first from their beginning alone."""
    known = record.first(samples)
    scale = np.array([1.0, model.speed])
    best = np.array(first_state(known)) / scale

    def misfit(x: Array, span: int) -> Array:
        return residual(record, model, x * scale, span)

    for share in shares(known, states_of(known).w):
        at = (max(16, int(share * samples)),)
        best = least_squares(misfit, best, x_scale="jac", diff_step=[STEP] * 2, max_nfev=60, args=at).x
    return float(best[0] * scale[0]), float(best[1] * scale[1])


def score(model: Model, task: Task) -> Score:
    """Of a row whose coefficients are known."""
    phi, v = fitted_start(task.scored, model, task.start)
    every = scored_samples(task)
    return score_motion(simulate(model, phi, v, task.scored.time_s[every]), task, every)


def score_motion(motion: Motion, task: Task, every: slice) -> Score:
    """Of a motion at the samples `every` of the record."""
    first = len(range(*every.indices(task.start)))
    if not np.isfinite(motion.phi).all():
        return Score(math.inf, math.inf)
    made = observed(task.scored, motion, slice(0, first), every)
    signal = task.scored.signal[:, every]
    return Score(_nrmse(made[:, :first], signal[:, :first]), _nrmse(made[:, first:], signal[:, first:]))


def scored_samples(task: Task) -> slice:
    """Which samples are compared: all of an angle, some of dm/dt."""
    return slice(0, None, max(1, task.scored.time_s.size // _SCORE_POINTS))


def _nrmse(made: Array, signal: Array) -> float:
    centred = signal - signal.mean(axis=1, keepdims=True)
    return float(np.sqrt(np.mean((made - signal) ** 2) / np.mean(centred**2)))

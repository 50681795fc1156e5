"""Prediction of data that were not used: the proof of an effect.

Each held-out shot keeps its own start (phase, natural frequency, amplitude, orientation, offsets) from the first 30 %
of its window; the losses, the moment and the strengths of effects come from the other shots, give or take what they
scatter; the rest of the window is scored. A single shot is split in time: everything from its first 70 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.arrays import Array
from platform_daemon.estimation.gauss_newton import FitState
from platform_daemon.estimation.trajectory import LostTrajectoryError

from .hypothesis import Hypothesis
from .predict import own_sizes, predicted, window_of
from .refit import Linear, Refit, linearise
from .shots import Started

_OWN = 0.3  # of the window
_SPLIT = 0.7  # of the window of a single shot
_STEPS = 8
_SETTLED = 0.02  # fall of chi^2 that a further step would bring


@dataclass(frozen=True)
class Score:
    """Sums over all samples of the scored parts: chi^2, its expectation, squares of the residual and of the data.

    whole: chi^2 of the whole window, for effects that live at its beginning.
    """

    chi2: float
    dof: float
    squares: float
    energy: float
    whole: float

    @property
    def chi2_per_dof(self) -> float:
        """1 if nothing but noise is left."""
        return self.chi2 / self.dof

    @property
    def nrmse(self) -> float:
        """Rms of the residual over rms of the data."""
        return float(np.sqrt(self.squares / self.energy))


@dataclass(frozen=True)
class HeldOut:
    """Scores of every shot, None where its prediction leads nowhere."""

    by_shot: tuple[Score | None, ...]

    @property
    def total(self) -> Score:
        """Of all shots together; a shot without prediction counts as residual what its data are."""
        good = [s for s in self.by_shot if s is not None]
        sums = [sum(getattr(s, name) for s in good) for name in ("chi2", "dof", "squares", "energy", "whole")]
        return Score(*sums)


def held_out(at: Refit, pool: Executor) -> HeldOut:
    """Score a hypothesis by data that were not used for it."""
    count = len(at.started)
    work = _split_in_time if count == 1 else _leave_out
    return HeldOut(tuple(pool.map(lambda k: _guarded(work, at, k), range(count))))


def _guarded(work, at: Refit, k: int) -> Score | None:  # type: ignore[no-untyped-def]
    try:
        return work(at, k)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def _leave_out(at: Refit, k: int) -> Score:
    """Predict shot k from the others."""
    others = [j for j in range(len(at.started)) if j != k]
    strengths = _strengths_without(at, k)
    mean, sd = _known(at, others, k)
    keep = _rows(at.started[k], _OWN)
    state = _fitted(at.started[k], at.hypothesis, at.states[k], strengths, keep, mean, sd)
    return _scored(at.started[k], at.hypothesis, state, strengths, keep, _OWN)


def _split_in_time(at: Refit, k: int) -> Score:
    """Predict the end of a shot from its beginning; strengths too are fitted to that alone."""
    started, hypothesis = at.started[k], at.hypothesis
    keep = _rows(started, _SPLIT)
    state, strengths = at.states[k], at.strengths
    for _ in range(_STEPS):
        linear = linearise(started, hypothesis, state, strengths)
        both = np.concatenate([_base(linear), linear.columns], axis=1)[keep]
        step, fall = _solved(both, linear.residual[keep])
        own = linear.q.shape[1]
        state, strengths = state.moved(step[:own]), strengths + step[own:]
        if fall < _SETTLED:
            break
    return _scored(started, hypothesis, state, strengths, keep, _SPLIT)


def _base(linear: Linear) -> Array:
    """Columns of the declared parameters, (rows, p)."""
    return np.asarray((linear.q @ linear.triangle) / linear.scale)


def _solved(columns: Array, residual: Array) -> tuple[Array, float]:
    """Least-squares step and the fall of chi^2 it predicts."""
    norm = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    scaled = columns / norm
    step = np.linalg.lstsq(scaled, residual, rcond=1e-10)[0]
    return step / norm, float(residual @ (scaled @ step))


def _rows(started: Started, end: float) -> np.ndarray:
    """Rows of the instants before this share of the window, bool (channels m,)."""
    time = started.time_s
    return np.tile(time - time[0] < end * (time[-1] - time[0]), started.shot.record.channels)


def _strengths_without(at: Refit, k: int) -> Array:
    """Common strengths from all shots but k, by one linear step."""
    size = at.hypothesis.size
    if size == 0:
        return at.strengths
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    for j, linear in enumerate(at.linear):
        if j != k:
            rest = linear.columns - linear.q @ (linear.q.T @ linear.columns)
            matrix += rest.T @ rest
            gradient += rest.T @ linear.residual
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    step = scale * np.linalg.lstsq(matrix * np.outer(scale, scale), gradient * scale, rcond=1e-12)[0]
    return np.asarray(at.strengths + step)


def _places(at: Refit) -> list[int]:
    """Parameters of a declared state that the others know: losses and further coefficients, and the moment."""
    coefficients = len(at.hypothesis.model.coefficients)
    state = at.states[0]
    moment = [3 + coefficients] if state.observation.size == 4 else []
    return [*range(3, 3 + coefficients), *moment]


def _values(at: Refit, state: FitState) -> Array:
    """Their values in a state."""
    moment = [getattr(state.observation, "m_r", 0.0)] if state.observation.size == 4 else []
    return np.array([*state.dynamics.values[: len(at.hypothesis.model.coefficients)], *moment])


def _known(at: Refit, others: Sequence[int], k: int) -> tuple[Array, Array]:
    """(places' expected change from shot k's own fit, its standard deviation), from the other shots."""
    places = _places(at)
    values = np.stack([_values(at, at.states[j]) for j in others])
    spreads = np.stack([np.diag(at.linear[j].own_covariance())[places] for j in others])
    scatter = values.var(axis=0, ddof=1) if len(others) > 1 else np.zeros(len(places))
    excess = np.maximum(scatter - spreads.mean(axis=0), 0.0) * (1.0 + 1.0 / len(others))
    # What scatters no more than its errors allow is common to all shots.
    sure = scatter > spreads.mean(axis=0) * (1.0 + 4.0 / np.sqrt(max(2.0 * (len(others) - 1), 1.0)))
    variance = np.where(sure, excess, 0.0) + spreads.mean(axis=0) / len(others)
    return values.mean(axis=0) - _values(at, at.states[k]), np.sqrt(variance)


def _fitted(
    started: Started,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    keep: np.ndarray,
    mean: Array,
    sd: Array,
) -> FitState:
    """Start parameters from the kept rows, the others from what is known of them."""
    gone = np.zeros(mean.size)
    for _ in range(_STEPS):
        linear = linearise(started, hypothesis, state, strengths)
        places = [*range(3, 3 + len(hypothesis.model.coefficients))]
        places += [places[-1] + 1 if places else 3] if state.observation.size == 4 else []
        prior = np.zeros((mean.size, linear.q.shape[1]))
        prior[np.arange(mean.size), places] = 1.0 / sd
        columns = np.concatenate([_base(linear)[keep], prior])
        residual = np.concatenate([linear.residual[keep], (mean - gone) / sd])
        step, fall = _solved(columns, residual)
        state = state.moved(step)
        gone += step[places]
        if fall < _SETTLED:
            break
    return state


def _scored(
    started: Started, hypothesis: Hypothesis, state: FitState, strengths: Array, keep: np.ndarray, begin: float
) -> Score:
    """Of all samples from the share `begin` of the window on; the shot's own additive effects are fitted to `keep`."""
    linear = linearise(started, hypothesis, state, strengths)
    own = own_sizes(hypothesis, linear, strengths, keep)
    first, last = window_of(started)
    data = started.shot.record.samples[:, first:last]
    left = data - predicted(hypothesis, linear, state, strengths, own)
    data = data - state.offsets[:, None]
    weights = np.asarray(started.shot.noise.sd)[:, None] ** -2.0
    rest = slice(round(begin * (last - first)), None)
    squares = weights[:, 0] * np.sum(left[:, rest] ** 2, axis=1)
    whole = float(np.sum(weights * left**2))
    return Score(
        float(squares.sum()), float(left[:, rest].size), float(np.sum(left[:, rest] ** 2)),
        float(np.sum(data[:, rest] ** 2)), whole,
    )  # fmt: skip

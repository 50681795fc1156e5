"""Prediction of data that were not used: the proof of an effect.

Each held-out shot keeps its own start (phase, natural frequency, amplitude, orientation, offsets) from the first 30 %
of its window; the losses, the moment and the strengths of effects come from the other shots, give or take what they
scatter; the rest of the window is scored. A single shot is split in time: everything from its first 70 %.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from platform_daemon.estimation import Array, DipoleObservation, FitState, LostTrajectoryError

from ..shots.shot import PreparedShot
from .hypothesis import Hypothesis
from .information import solved
from .joint_fit import JointFit
from .linearised_shot import LinearisedShot, common_information, linearise_shot
from .prediction import own_sizes, predicted, window_of

_OWN = 0.3  # of the window
_SPLIT = 0.7  # of the window of a single shot
_STEPS = 8
_SETTLED = 0.02  # fall of chi^2 that a further step would bring
_FRACTIONS = (1.0, 0.3, 0.1, 0.03)


@dataclass(frozen=True)
class HeldOutScore:
    """Sums over all samples of the scored parts: chi^2, its expectation, squares of the residual and of the data.

    chi2: counts the errors of the prediction too, so that it is dof if nothing but noise is left.
    whole: chi^2 of the whole window with the start fitted to all of it, and everything else as held out: what the
        choice between effects rests on, because the noise of a start from 30 % would drown small ones.
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
class CrossValidation:
    """Scores of every shot, None where its prediction leads nowhere."""

    by_shot: tuple[HeldOutScore | None, ...]

    @property
    def total(self) -> HeldOutScore:
        """Of all shots that could be predicted."""
        good = [s for s in self.by_shot if s is not None]
        if not good:
            return HeldOutScore(math.inf, 1.0, math.inf, 1.0, math.inf)
        sums = [sum(getattr(s, name) for s in good) for name in ("chi2", "dof", "squares", "energy", "whole")]
        return HeldOutScore(*sums)

    def worse_by(self, other: CrossValidation) -> float:
        """Rise of chi^2 against another hypothesis; infinite for one that cannot predict what the other can."""
        rises = [_rise(a, b) for a, b in zip(self.by_shot, other.by_shot, strict=True)]
        return math.inf if math.inf in rises else sum(rises)


def _rise(a: HeldOutScore | None, b: HeldOutScore | None) -> float:
    """Of one shot's chi^2 from b to a."""
    if a is None or b is None:
        return 0.0 if a is b else math.inf if a is None else -math.inf
    return a.whole - b.whole


def cross_validate(at: JointFit, pool: Executor) -> CrossValidation:
    """Score a hypothesis by data that were not used for it."""
    count = len(at.started)
    work = _split_in_time if count == 1 else _leave_out
    return CrossValidation(tuple(pool.map(lambda k: _guarded(work, at, k), range(count))))


def _guarded(work, at: JointFit, k: int) -> HeldOutScore | None:  # type: ignore[no-untyped-def]
    try:
        return work(at, k)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def _leave_out(at: JointFit, k: int) -> HeldOutScore:
    """Predict shot k from the others."""
    others = [j for j in range(len(at.started)) if j != k]
    strengths, sure = _strengths_without(at, k)
    mean, sd = _known(at, others, k)
    keep = _rows(at.started[k], _OWN)
    # Own parameters follow the change of the strengths at once: a stiffness moves the phase of the end by turns.
    moved = at.linear[k].own_step(strengths - at.strengths)
    start = at.states[k].moved(moved)
    mean = mean - moved[_places(at)]
    every, args = np.ones_like(keep), (at.started[k], at.hypothesis, start, strengths)
    _, whole = _fitted(*args, every, mean, sd)
    state, _ = _fitted(*args, keep, mean, sd)
    own = at.linear[k].free.size
    known = np.zeros((mean.size + len(sure), own + len(sure)))
    known[np.arange(mean.size), _places(at)] = 1.0 / sd
    known[mean.size :, own:] = sure
    return _scored(at.started[k], at.hypothesis, state, strengths, keep, _OWN, whole, known)


def _split_in_time(at: JointFit, k: int) -> HeldOutScore:
    """Predict the end of a shot from its beginning; strengths too are fitted to that alone."""
    started, hypothesis = at.started[k], at.hypothesis
    keep = _rows(started, _SPLIT)
    state, strengths = at.states[k], at.strengths
    for _ in range(_STEPS):
        linear = linearise_shot(started, hypothesis, state, strengths)
        both = np.concatenate([linear.base(), linear.columns], axis=1)[keep]
        step, fall = _solved(both, linear.residual[keep])
        own = linear.free.size
        state, strengths = state.moved(step[:own]), strengths + step[own:]
        if fall < _SETTLED:
            break
    size = len(_places(at))
    _, whole = _fitted(started, hypothesis, state, strengths, np.ones_like(keep), np.zeros(size), np.full(size, np.inf))
    nothing = np.zeros((0, own + hypothesis.size))
    return _scored(started, hypothesis, state, strengths, keep, _SPLIT, whole, nothing)


def _solved(columns: Array, residual: Array) -> tuple[Array, float]:
    """Least-squares step and the fall of chi^2 it predicts."""
    norm = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    scaled = columns / norm
    step = np.linalg.lstsq(scaled, residual, rcond=1e-10)[0]
    return step / norm, float(residual @ (scaled @ step))


def _rows(started: PreparedShot, end: float) -> np.ndarray:
    """Rows of the instants before this share of the window, bool (channels m,)."""
    time = started.time_s
    return np.tile(time - time[0] < end * (time[-1] - time[0]), started.shot.record.channels)


def _strengths_without(at: JointFit, k: int) -> tuple[Array, Array]:
    """Common strengths (q,) from all shots but k, by one linear step, and the root of their information, (q, q)."""
    size = at.hypothesis.size
    if size == 0:
        return at.strengths, np.zeros((0, 0))
    matrix, gradient = common_information((a for j, a in enumerate(at.linear) if j != k), size)
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T * scale
    return np.asarray(at.strengths + solved(matrix, gradient)), root


def _places(at: JointFit) -> list[int]:
    """Parameters of a declared state that the others know: losses and further coefficients, and the moment."""
    coefficients = len(at.hypothesis.model.coefficients)
    state = at.states[0]
    moment = [3 + coefficients] if _is_dipole(state) else []
    return [*range(3, 3 + coefficients), *moment]


def _is_dipole(state: FitState) -> bool:
    return isinstance(state.observation, DipoleObservation)


def _values(at: JointFit, state: FitState) -> Array:
    """Their values in a state."""
    moment = [state.observation.m_r] if isinstance(state.observation, DipoleObservation) else []
    own = state.dynamics.values[: len(at.hypothesis.model.coefficients)]
    values = [0.0 if n in at.hypothesis.gone else q for n, q in enumerate(own)]
    return np.array([*values, *moment])


def _known(at: JointFit, others: Sequence[int], k: int) -> tuple[Array, Array]:
    """(places' expected change from shot k's own fit, its standard deviation), from the other shots.

    How much the shots scatter is told by all of them: two that agree by chance would promise too much for a third.
    """
    places = _places(at)
    values = np.stack([_values(at, state) for state in at.states])
    spreads = np.stack([np.diag(a.own_covariance())[places] for a in at.linear])
    error, freedom = spreads.mean(axis=0), len(values) - 1
    scatter = values.var(axis=0, ddof=1)
    excess = np.maximum(scatter - error, 0.0) * (1.0 + 1.0 / len(others)) * _wide(freedom)
    # What scatters no more than its errors allow is common to all shots.
    sure = scatter > error * (1.0 + 4.0 / np.sqrt(2.0 * freedom))
    variance = np.where(sure, excess, 0.0) + error / len(others)
    # What is held has neither scatter nor error.
    return values[others].mean(axis=0) - values[k], np.sqrt(np.where(variance > 0.0, variance, 1.0))


def _wide(freedom: int) -> float:
    """By how much a variance known from few values is to be widened, so that a normal law holds 95 % all the same."""
    return float((student.ppf(0.975, freedom) / norm.ppf(0.975)) ** 2)


def _fitted(
    started: PreparedShot,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    keep: np.ndarray,
    mean: Array,
    sd: Array,
) -> tuple[FitState, float]:
    """Start parameters from the kept rows, the others from what is known of them; chi^2 of both at the end.

    Raises:
        LostTrajectoryError: no way down.
    """
    places = [*range(3, 3 + len(hypothesis.model.coefficients))]
    places += [3 + len(hypothesis.model.coefficients)] if _is_dipole(state) else []
    prior = np.zeros((mean.size, hypothesis.reduced(state).size))
    prior[np.arange(mean.size), places] = 1.0 / sd
    linear, gone = linearise_shot(started, hypothesis, state, strengths), np.zeros(mean.size)
    chi2 = _penalised(linear, keep, (mean - gone) / sd)
    for _ in range(_STEPS):
        columns = np.concatenate([linear.base()[keep], prior])
        residual = np.concatenate([linear.residual[keep], (mean - gone) / sd])
        step, fall = _solved(columns, residual)
        if fall < _SETTLED:
            break
        for fraction in _FRACTIONS:
            moved = state.moved(fraction * step)
            try:
                trial = linearise_shot(started, hypothesis, moved, strengths)
            except LostTrajectoryError:
                continue
            there = _penalised(trial, keep, (mean - gone - fraction * step[places]) / sd)
            if there < chi2:
                break
        else:
            break
        linear, state, chi2, gone = trial, moved, there, gone + fraction * step[places]
    return state, chi2


def _uncertain(linear: LinearisedShot, keep: np.ndarray, known: Array) -> float:
    """Part of the rest's chi^2 that lies within the errors of the prediction, which is made from the kept rows.

    With e the errors of what is predicted, chi^2 = r (1 + e e^T)^-1 r has an expectation of one per sample.
    """
    columns = np.concatenate([linear.base(), linear.columns], axis=1)
    norm = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    before = np.linalg.qr(np.concatenate([columns[keep], known]) / norm, mode="r")
    wide = np.concatenate([columns[~keep] / norm, before])
    target = np.concatenate([linear.residual[~keep], np.zeros(len(before))])
    step = np.linalg.lstsq(wide, target, rcond=1e-12)[0]
    return float(target @ (wide @ step))


def _penalised(linear: LinearisedShot, keep: np.ndarray, miss: Array) -> float:
    """chi^2 of the kept rows and of what is known."""
    rows = linear.residual[keep]
    return float(rows @ rows + miss @ miss)


def _scored(
    started: PreparedShot,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    keep: np.ndarray,
    begin: float,
    whole: float,
    known: Array,
) -> HeldOutScore:
    """Of all samples from the share `begin` of the window on; the shot's own additive effects are fitted to `keep`.

    known: (..., parameters of the shot and strengths) what is known of these besides, in standard deviations.
    """
    linear = linearise_shot(started, hypothesis, state, strengths)
    own = own_sizes(hypothesis, linear, strengths, keep)
    first, last = window_of(started)
    data = started.shot.record.samples[:, first:last]
    left = data - predicted(hypothesis, linear, state, strengths, own)
    data = data - state.offsets[:, None]
    weights = np.asarray(started.shot.noise.sd)[:, None] ** -2.0
    rest = slice(round(begin * (last - first)), None)
    squares = weights[:, 0] * np.sum(left[:, rest] ** 2, axis=1)
    chi2 = float(squares.sum()) - _uncertain(linear, keep, known)
    return HeldOutScore(
        chi2, float(left[:, rest].size), float(np.sum(left[:, rest] ** 2)),
        float(np.sum(data[:, rest] ** 2)), whole,
    )  # fmt: skip

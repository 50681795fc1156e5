"""Prediction of held-out data, on which the proof of an effect rests.

Each held-out shot keeps its own start (phase, natural frequency, amplitude, orientation, offsets) from the first 30 %
of its window; the losses, the moment and the strengths of effects come from the other shots, within their
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

from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.torque_course import ProcessNoise, SplitNoise
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .hypothesis import Hypothesis
from .information import solved
from .joint_fit import JointFit, settled_chi2
from .linearised_shot import LinearisedShot, common_information, linearise_shot
from .prediction import own_sizes, predicted, window_of

_BOUNDLESS = 1.0 / np.finfo(float).eps  # of any parameter: beyond, the equations determine nothing
_LIMITS = THRESHOLDS.regression


@dataclass(frozen=True, kw_only=True)
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
            return HeldOutScore(chi2=math.inf, dof=1.0, squares=math.inf, energy=1.0, whole=math.inf)
        return HeldOutScore(
            chi2=sum(s.chi2 for s in good),
            dof=sum(s.dof for s in good),
            squares=sum(s.squares for s in good),
            energy=sum(s.energy for s in good),
            whole=sum(s.whole for s in good),
        )

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
    count = len(at.prepared)
    work = _split_in_time if count == 1 else _leave_out
    return CrossValidation(tuple(pool.map(lambda k: _guarded(work, at, k), range(count))))


def _guarded(work, at: JointFit, k: int) -> HeldOutScore | None:  # type: ignore[no-untyped-def]
    try:
        return work(at, k)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def _leave_out(at: JointFit, k: int) -> HeldOutScore:
    """Predict shot k from the others."""
    others = [j for j in range(len(at.prepared)) if j != k]
    strengths, sure = _strengths_without(at, k)
    mean, sd = _known(at, others, k)
    keep = _rows(at.prepared[k], _LIMITS.own_share)
    # Own parameters follow the change of the strengths at once: a stiffness moves the phase of the end by turns.
    moved = at.linear[k].own_step(strengths - at.strengths)
    start = at.states[k].moved(moved)
    mean = mean - moved[_places(at)]
    shot, hypothesis = at.prepared[k], at.hypothesis
    _, whole = _fitted(shot, hypothesis, start, strengths, keep=np.ones_like(keep), mean=mean, sd=sd)
    state, _ = _fitted(shot, hypothesis, start, strengths, keep=keep, mean=mean, sd=sd)
    own = at.linear[k].free.size
    known = np.zeros((mean.size + len(sure), own + len(sure)))
    known[np.arange(mean.size), _places(at)] = 1.0 / sd
    known[mean.size :, own:] = sure
    begin = _LIMITS.own_share
    return _scored(shot, hypothesis, state, strengths, keep=keep, begin=begin, whole=whole, known=known)


def _split_in_time(at: JointFit, k: int) -> HeldOutScore:
    """Predict the end of a shot from its beginning; strengths too are fitted to that alone."""
    prepared, hypothesis = at.prepared[k], at.hypothesis
    keep = _rows(prepared, _LIMITS.split_share)
    state, strengths = at.states[k], at.strengths
    linear = linearise_shot(prepared, hypothesis, state, strengths)
    own = linear.free.size
    for _ in range(_LIMITS.prediction_steps):
        both = np.concatenate([linear.base(), linear.columns], axis=1)[keep]
        step, fall = least_squares_step(both, linear.residual[keep])
        if not np.all(np.abs(step) < _BOUNDLESS):
            raise LostTrajectoryError("the beginning of the shot does not determine the strengths")
        if fall < _LIMITS.settled_chi2:
            break
        better = _descended(linear, prepared, hypothesis, state, strengths, step, keep)
        if better is None:
            break
        linear, state, strengths = better
    size = len(_places(at))
    _, whole = _fitted(
        prepared,
        hypothesis,
        state,
        strengths,
        keep=np.ones_like(keep),
        mean=np.zeros(size),
        sd=np.full(size, np.inf),
    )
    nothing = np.zeros((0, own + hypothesis.size))
    begin = _LIMITS.split_share
    return _scored(prepared, hypothesis, state, strengths, keep=keep, begin=begin, whole=whole, known=nothing)


def _descended(
    linear: LinearisedShot,
    prepared: PreparedShot,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    step: Array,
    keep: np.ndarray,
) -> tuple[LinearisedShot, FitState, Array] | None:
    """After the longest of some parts of a step that goes down in the kept rows; None: none does."""
    own, before = linear.free.size, float(np.sum(linear.residual[keep] ** 2))
    for fraction in _LIMITS.prediction_fractions:
        moved, stronger = state.moved(fraction * step[:own]), strengths + fraction * step[own:]
        try:
            trial = linearise_shot(prepared, hypothesis, moved, stronger)
        except LostTrajectoryError:
            continue
        if float(np.sum(trial.residual[keep] ** 2)) < before:
            return trial, moved, stronger
    return None


def least_squares_step(columns: Array, residual: Array) -> tuple[Array, float]:
    """Least-squares step and the fall of chi^2 it predicts."""
    norm = np.linalg.norm(columns, axis=0)
    norm = np.where(norm > 0.0, norm, 1.0)  # of a loss that is held; a rounding error over next to nothing is no step
    scaled = columns / norm
    step = np.linalg.lstsq(scaled, residual, rcond=_LIMITS.step_rank)[0]
    return step / norm, float(residual @ (scaled @ step))


def _rows(prepared: PreparedShot, end: float) -> np.ndarray:
    """Rows of the instants before this share of the window, bool (channels m,)."""
    time = prepared.time_s
    return np.tile(time - time[0] < end * (time[-1] - time[0]), prepared.shot.record.channels)


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
    """Values of the shared parameters in a state: coefficients of the model (0 where held at zero), then m_r."""
    moment = [state.observation.m_r] if isinstance(state.observation, DipoleObservation) else []
    own = state.dynamics.values[: len(at.hypothesis.model.coefficients)]
    values = [0.0 if n in at.hypothesis.held_at_zero else q for n, q in enumerate(own)]
    return np.array([*values, *moment])


def _known(at: JointFit, others: Sequence[int], k: int) -> tuple[Array, Array]:
    """(places' expected change from shot k's own fit, its standard deviation), from the other shots.

    The scatter is estimated from all shots: two that agree by chance would promise too much for a third.
    """
    places = _places(at)
    values = np.stack([_values(at, state) for state in at.states])
    spreads = np.stack([np.diag(a.own_covariance())[places] for a in at.linear])
    error, freedom = spreads.mean(axis=0), len(values) - 1
    scatter = values.var(axis=0, ddof=1)
    excess = np.maximum(scatter - error, 0.0) * (1.0 + 1.0 / len(others)) * _wide(freedom)
    # What scatters no more than its errors allow is common to all shots.
    sure = scatter > error * (1.0 + _LIMITS.scatter_sigma / np.sqrt(2.0 * freedom))
    variance = np.where(sure, excess, 0.0) + error / len(others)
    # What is held has neither scatter nor error.
    return values[others].mean(axis=0) - values[k], np.sqrt(np.where(variance > 0.0, variance, 1.0))


def _wide(freedom: int) -> float:
    """By how much a variance known from few values is to be widened, so that a normal law holds 95 % all the same."""
    quantile = _LIMITS.scatter_quantile
    return float((student.ppf(quantile, freedom) / norm.ppf(quantile)) ** 2)


def _fitted(
    prepared: PreparedShot,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    *,
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
    linear, change = linearise_shot(prepared, hypothesis, state, strengths), np.zeros(mean.size)
    part, enough = _Part.of(linear, keep), settled_chi2(state)
    chi2 = part.chi2(linear, (mean - change) / sd)
    for _ in range(_LIMITS.prediction_steps):
        columns = np.concatenate([part.used(linear.base()), prior])
        residual = np.concatenate([part.used(linear.residual), (mean - change) / sd])
        step, fall = least_squares_step(columns, residual)
        if fall < enough:
            break
        for fraction in _LIMITS.prediction_fractions:
            moved = state.moved(fraction * step)
            try:
                trial = linearise_shot(prepared, hypothesis, moved, strengths)
            except LostTrajectoryError:
                continue
            further = _Part.of(trial, keep)
            there = further.chi2(trial, (mean - change - fraction * step[places]) / sd)
            if there < chi2:
                break
        else:
            break
        linear, part = trial, further
        state = moved
        chi2 = there
        change = change + fraction * step[places]
    return state, chi2


def _uncertain(linear: LinearisedShot, keep: np.ndarray, known: Array) -> float:
    """Part of the held-out chi^2 that lies within the errors of the prediction, which is made from the kept rows.

    With e the errors of what is predicted, chi^2 = r (1 + e e^T)^-1 r has an expectation of one per sample.
    """
    columns = np.concatenate([linear.base(), linear.columns], axis=1)
    norm = np.linalg.norm(columns, axis=0)
    norm[norm == 0.0] = 1.0  # these samples tell nothing of it
    part = _Part.of(linear, keep)
    used, predicted = part.used(columns / norm), part.predicted(columns / norm)
    before = np.linalg.qr(np.concatenate([used, known / norm]), mode="r")
    wide = np.concatenate([predicted, before])
    target = np.concatenate([part.predicted(linear.residual), np.zeros(len(before))])
    step = np.linalg.lstsq(wide, target, rcond=_LIMITS.error_rank)[0]
    return float(target @ (wide @ step))


@dataclass(frozen=True)
class _Part:
    """Which rows of a shot are known; split: what their noise says about the others, None: nothing."""

    keep: np.ndarray
    split: SplitNoise | None

    @classmethod
    def of(cls, linear: LinearisedShot, keep: np.ndarray) -> _Part:
        process = linear.linearisation.process
        return cls(keep, None if process is None or keep.all() else process.split_at(keep))

    def used(self, rows: Array) -> Array:
        """The known ones of rows (rows, ...) in units of their noise."""
        return rows[self.keep] if self.split is None else self.split.first(rows.T).T

    def predicted(self, rows: Array) -> Array:
        """The others, given those."""
        return rows[~self.keep] if self.split is None else self.split.rest(rows.T)[0].T

    def chi2(self, linear: LinearisedShot, miss: Array) -> float:
        """Of the known rows and of what is known besides."""
        rows = self.used(linear.residual)
        return float(rows @ rows + miss @ miss)


def _scored(
    prepared: PreparedShot,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    *,
    keep: np.ndarray,
    begin: float,
    whole: float,
    known: Array,
) -> HeldOutScore:
    """Of all samples from the share `begin` of the window on; the shot's own additive effects are fitted to `keep`.

    known: (..., parameters of the shot and strengths) what is known of these besides, in standard deviations.
    """
    linear = linearise_shot(prepared, hypothesis, state, strengths)
    if linear.linearisation.process is not None:
        return _scored_beside_course(linear, linear.linearisation.process, keep, whole, known)
    own = own_sizes(hypothesis, linear, strengths, keep)
    first, last = window_of(prepared)
    data = prepared.shot.record.samples[:, first:last]
    left = data - predicted(hypothesis, linear, state, strengths, own)
    data = data - state.offsets[:, None]
    weights = np.asarray(prepared.shot.noise.sd)[:, None] ** -2.0
    rest = slice(round(begin * (last - first)), None)
    squares = weights[:, 0] * np.sum(left[:, rest] ** 2, axis=1)
    chi2 = float(squares.sum()) - _uncertain(linear, keep, known)
    return HeldOutScore(
        chi2=chi2,
        dof=float(left[:, rest].size),
        squares=float(np.sum(left[:, rest] ** 2)),
        energy=float(np.sum(data[:, rest] ** 2)),
        whole=whole,
    )


def _scored_beside_course(
    linear: LinearisedShot, process: ProcessNoise, keep: np.ndarray, whole: float, known: Array
) -> HeldOutScore:
    """Of all instants that are not kept; of the torque's course there, what the kept ones say about it is known."""
    at = linear.linearisation
    rest, left = process.split_at(keep).rest(linear.residual)
    sizes = at.prepared.white.scale.reshape(-1)[~keep]
    data = (at.prepared.data - at.state.offsets[:, None]).reshape(-1)[~keep]
    return HeldOutScore(
        chi2=float(rest @ rest) - _uncertain(linear, keep, known),
        dof=at.prepared.dof * float(np.count_nonzero(~keep)) / keep.size,
        squares=float(np.sum((left / sizes) ** 2)),
        energy=float(np.sum(data**2)),
        whole=whole,
    )

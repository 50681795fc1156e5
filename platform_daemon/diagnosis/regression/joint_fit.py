"""Joint fit of several shots: every shot keeps its declared parameters, effects have common strengths.

Gauss-Newton from fits of the declared model. Torque effects are in the equation of motion, receiver effects change
the model's channels (Candidate.change), additive effects are linear.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.torque_course import course_of
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .hypothesis import Hypothesis
from .information import inverse, solved
from .linearised_shot import LinearisedShot, common_information, linearise_shot

_LIMITS = THRESHOLDS.regression


@dataclass(frozen=True, kw_only=True)
class _Point:
    """States of all shots, common strengths (q,), and the shots linearised there."""

    states: tuple[FitState, ...]
    strengths: Array
    linear: tuple[LinearisedShot, ...]

    @property
    def chi2(self) -> float:
        """Of all shots together."""
        return sum(a.chi2 for a in self.linear)


@dataclass(frozen=True, kw_only=True)
class JointFit:
    """A joint minimum.

    states: of every shot, of the declared model. strengths (q,) and their covariance (q, q) in the order of
    hypothesis.common; linear: every shot at its state.
    """

    prepared: Sequence[PreparedShot]
    hypothesis: Hypothesis
    states: tuple[FitState, ...]
    strengths: Array
    covariance: Array
    linear: tuple[LinearisedShot, ...]

    @property
    def chi2(self) -> float:
        """Of all shots."""
        return sum(a.chi2 for a in self.linear)

    @property
    def dof(self) -> float:
        """Its expectation, if nothing is missing."""
        return sum(s.dof - a.parameters for s, a in zip(self.prepared, self.linear, strict=True)) - self.hypothesis.size

    @property
    def chi2_per_dof(self) -> float:
        """1 if nothing but the measured noise is left."""
        return self.chi2 / self.dof

    @property
    def leaves_noise(self) -> bool:
        """Nothing but noise is left, as far as its size tells."""
        return self.chi2_per_dof < _LIMITS.noise_chi2_per_dof

    @cached_property
    def noise_factor(self) -> float:
        """The divisor of gains of chi^2 where the residual is larger than the measured noise.

        Neighbouring samples of a model error are correlated, so that only independent values count.
        """
        return noise_factor(self.chi2_per_dof, ((a.chi2, partial(_samples_per_value, a)) for a in self.linear))

    def without_processes(self) -> JointFit:
        """A copy to be kept among many: steps from it leave the courses of a torque as they are."""
        return replace(self, linear=tuple(a.without_process() for a in self.linear))

    def full_state(self, k: int) -> FitState:
        """Of shot k, with the torque strengths among its coefficients."""
        return self.hypothesis.extended(self.states[k], self.strengths)


def _samples_per_value(of: LinearisedShot) -> float:
    return of.samples_per_value


def noise_factor(chi2_per_dof: float, left: Iterable[tuple[float, Callable[[], float]]]) -> float:
    """The divisor of gains; left: of each shot its chi^2, and the number of samples per independent value."""
    if chi2_per_dof < _LIMITS.noise_chi2_per_dof:
        return max(1.0, chi2_per_dof)
    pairs = [(chi2, each()) for chi2, each in left]
    return chi2_per_dof * sum(chi2 * each for chi2, each in pairs) / sum(chi2 for chi2, _ in pairs)


def settled_chi2(state: FitState) -> float:
    """Predicted fall of chi^2 at which a fit ends: beside the course of a torque, that moves chi^2 by more itself."""
    beside = course_of(state) is not None
    return THRESHOLDS.fluctuation.fitted_chi2 if beside else _LIMITS.settled_chi2


def fit_jointly(
    prepared: Sequence[PreparedShot],
    hypothesis: Hypothesis,
    pool: Executor,
    states: Sequence[FitState] | None = None,
    guess: Array | None = None,
    worth: float = math.inf,
) -> JointFit:
    """Minimise chi^2 of all shots.

    states: of the declared model, to begin at; None: as the shots were prepared. guess: strengths (q,); None: 0.
    worth: chi^2 from which down the fit is of interest; where it is out of reach the search ends before the minimum.

    Raises:
        LostTrajectoryError: a state does not oscillate.
    """
    strengths = np.zeros(hypothesis.size) if guess is None else np.asarray(guess, dtype=np.float64)
    states = [s.state for s in prepared] if states is None else states
    at = _point(prepared, hypothesis, states, strengths, pool)
    poor = 0
    for _ in range(_LIMITS.most_steps):
        common, predicted = _common_step(at.linear, hypothesis.size)
        before = at.chi2
        if before - _LIMITS.hope_ratio * predicted > worth or (poor >= _LIMITS.most_poor_steps and before > worth):
            break
        if predicted < settled_chi2(at.states[0]) * max(1.0, before / sum(s.dof for s in prepared)):
            at = _last_step(prepared, hypothesis, at, common, pool)
            break
        better = _line_search(prepared, hypothesis, at, common, pool)
        if better is None:
            break
        at = better
        poor = poor + 1 if before - at.chi2 < _LIMITS.poor_share * predicted else 0
    return JointFit(
        prepared=prepared,
        hypothesis=hypothesis,
        states=at.states,
        strengths=at.strengths,
        covariance=_covariance(at.linear, hypothesis.size),
        linear=at.linear,
    )


def _last_step(
    prepared: Sequence[PreparedShot], hypothesis: Hypothesis, at: _Point, common: Array, pool: Executor
) -> _Point:
    """After the step that is left beside the course of a torque, whatever that moves chi^2 by itself: without it a fit
    would end up to two standard deviations off."""
    if course_of(at.states[0]) is None:
        return at
    last = _stepped(prepared, hypothesis, at, common, pool)
    return at if last is None or last.chi2 > at.chi2 + settled_chi2(at.states[0]) else last


def starting_strengths(at: JointFit, hypothesis: Hypothesis) -> np.ndarray:
    """Strengths of a refit as the start of another hypothesis; 0 for new effects."""
    known = {c.key: at.strengths[s] for c, s in zip(at.hypothesis.common, at.hypothesis.slices, strict=True)}
    out = np.zeros(hypothesis.size)
    for c, s in zip(hypothesis.common, hypothesis.slices, strict=True):
        if c.key in known:
            out[s] = known[c.key]
    return out


def starting_point(at: JointFit, hypothesis: Hypothesis) -> tuple[list[FitState], np.ndarray]:
    """States and strengths of a refit as the start of another hypothesis.

    All other parameters compensate, to first order, for effects that it lacks and for losses that it holds at 0;
    unchanged they would describe another motion.
    """
    keys = {c.key for c in hypothesis.common}
    held = [3 + k for k in hypothesis.held_at_zero if k not in at.hypothesis.held_at_zero]
    kept = np.zeros(at.hypothesis.size, dtype=bool)
    for c, s in zip(at.hypothesis.common, at.hypothesis.slices, strict=True):
        kept[s] = c.key in keys
    if kept.all() and not held:
        return list(at.states), starting_strengths(at, hypothesis)
    pairs = list(zip(at.states, at.linear, strict=True))
    rest = [a.without(s, held, np.where(kept, 0.0, at.strengths), kept) for s, a in pairs]
    common, _ = _common_step(rest, int(kept.sum()))
    strengths = at.strengths.copy()
    strengths[kept] += common
    states = [
        _at_zero(s.moved(a.own_step(common)), hypothesis.held_at_zero) for s, a in zip(at.states, rest, strict=True)
    ]
    return states, starting_strengths(replace(at, strengths=strengths), hypothesis)


def _at_zero(state: FitState, held_at_zero: Sequence[int]) -> FitState:
    """The state with these losses at 0."""
    values = tuple(0.0 if k in held_at_zero else q for k, q in enumerate(state.dynamics.values))
    return replace(state, dynamics=replace(state.dynamics, values=values))


def _point(
    prepared: Sequence[PreparedShot],
    hypothesis: Hypothesis,
    states: Sequence[FitState],
    strengths: Array,
    pool: Executor,
) -> _Point:
    """All shots linearised at their states.  Raises LostTrajectoryError, LinAlgError."""

    def one(shot: PreparedShot, state: FitState) -> LinearisedShot:
        return linearise_shot(shot, hypothesis, state, strengths)

    return _Point(states=tuple(states), strengths=strengths, linear=tuple(pool.map(one, prepared, states)))


def _common_step(at: Sequence[LinearisedShot], size: int) -> tuple[Array, float]:
    """Best step of the common strengths, and the fall of chi^2 it brings together with the shots' own steps."""
    matrix, gradient = common_information(at, size)
    step = solved(matrix, gradient)
    own = sum(float(np.sum((a.q.T @ a.residual) ** 2)) for a in at)
    return step, float(gradient @ step) + own


def _covariance(at: Sequence[LinearisedShot], size: int) -> Array:
    return inverse(common_information(at, size)[0]) if size else np.zeros((0, 0))


def _line_search(
    prepared: Sequence[PreparedShot], hypothesis: Hypothesis, at: _Point, common: Array, pool: Executor
) -> _Point | None:
    """The longest of ever shorter steps that goes down, or None.

    The valley of an effect that the shots' own parameters can nearly follow is narrow and bent: a good step along it
    leaves it sideways. After a step that goes up, the shots' own parameters may therefore return at the new strengths,
    and at last all parameters together, before the step is judged.
    """
    before = at.chi2
    fraction = 1.0
    while fraction > _LIMITS.smallest_fraction:
        trial = _stepped(prepared, hypothesis, at, common, pool, fraction=fraction)
        if trial is not None and trial.chi2 >= before:
            trial = _back_to_valley(prepared, hypothesis, trial, before, pool)
        if trial is not None and trial.chi2 < before:
            return trial
        fraction *= _LIMITS.shortening
    return None


def _back_to_valley(
    prepared: Sequence[PreparedShot], hypothesis: Hypothesis, at: _Point, before: float, pool: Executor
) -> _Point | None:
    """The shots' own parameters return at the strengths of `at`, until chi^2 of all is below `before`: that point.

    Where it stays above, one step of all parameters together comes last; None where nothing oscillates after that.
    """
    held = np.zeros(hypothesis.size)
    for _ in range(_LIMITS.valley_steps):
        nearer = _stepped(prepared, hypothesis, at, held, pool)
        if nearer is None or nearer.chi2 >= at.chi2:
            break
        at = nearer
        if at.chi2 < before:
            return at
    common, _ = _common_step(at.linear, hypothesis.size)
    return _stepped(prepared, hypothesis, at, common, pool)


def _stepped(
    prepared: Sequence[PreparedShot],
    hypothesis: Hypothesis,
    at: _Point,
    common: Array,
    pool: Executor,
    *,
    fraction: float = 1.0,
) -> _Point | None:
    """The point after a fraction of a step: `common` of the strengths, and the shots' own; None: nothing oscillates."""
    states = [s.moved(fraction * a.own_step(common)) for s, a in zip(at.states, at.linear, strict=True)]
    try:
        return _point(prepared, hypothesis, states, at.strengths + fraction * common, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None

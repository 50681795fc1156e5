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

from platform_daemon.estimation import Array, FitState, LostTrajectoryError

from ..shots.shot import PreparedShot
from .hypothesis import Hypothesis
from .information import inverse, solved
from .linearised_shot import LinearisedShot, common_information, linearise_shot

_MOST_STEPS = 12
_SETTLED = 0.02  # fall of chi^2 that a further step would bring
_HOPE = 3.0  # times the fall that a step promises: more is not expected of all further steps
_POOR, _MOST_POOR = 0.1, 2  # steps that bring less than this share of what they promise
_SMALLEST = 1e-3  # fraction of a step
_STRUCTURED = 1.1  # chi^2 per degree of freedom from which a residual is no noise
_BACK = 3  # steps of the shots' own parameters back into the valley


_There = tuple[list[FitState], Array, list[LinearisedShot]]
"""States, strengths, and all shots linearised at them."""


@dataclass(frozen=True)
class JointFit:
    """A joint minimum.

    states: of every shot, of the declared model. strengths (q,) and their covariance (q, q) in the order of
    hypothesis.common; linear: every shot at its state.
    """

    started: Sequence[PreparedShot]
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
        return sum(s.dof - a.parameters for s, a in zip(self.started, self.linear, strict=True)) - self.hypothesis.size

    @property
    def chi2_per_dof(self) -> float:
        """1 if nothing but the measured noise is left."""
        return self.chi2 / self.dof

    @cached_property
    def noise_factor(self) -> float:
        """By how much gains of chi^2 are to be divided where more is left than the measured noise.

        What a model leaves over goes on from sample to sample: it is worth as few values as are independent.
        """
        return noise_factor(self.chi2_per_dof, ((a.chi2, partial(_samples_per_value, a)) for a in self.linear))

    def full_state(self, k: int) -> FitState:
        """Of shot k, with the torque strengths among its coefficients."""
        return self.hypothesis.extended(self.states[k], self.strengths)


def _samples_per_value(of: LinearisedShot) -> float:
    return of.samples_per_value


def noise_factor(chi2_per_dof: float, left: Iterable[tuple[float, Callable[[], float]]]) -> float:
    """By how much gains are to be divided; left: chi^2 of each shot, and how many samples tell as much as one."""
    if chi2_per_dof < _STRUCTURED:
        return max(1.0, chi2_per_dof)
    pairs = [(chi2, each()) for chi2, each in left]
    return chi2_per_dof * sum(chi2 * each for chi2, each in pairs) / sum(chi2 for chi2, _ in pairs)


def fit_jointly(
    started: Sequence[PreparedShot],
    hypothesis: Hypothesis,
    pool: Executor,
    states: Sequence[FitState] | None = None,
    guess: Array | None = None,
    worth: float = math.inf,
) -> JointFit:
    """Minimise chi^2 of all shots.

    states: of the declared model, to begin at; None: as the shots were started. guess: strengths (q,); None: 0.
    worth: chi^2 from which down the fit is of interest; where it is out of reach the search ends before the minimum.

    Raises:
        LostTrajectoryError: a state does not oscillate.
    """
    strengths = np.zeros(hypothesis.size) if guess is None else np.asarray(guess, dtype=np.float64)
    states = [s.state for s in started] if states is None else list(states)
    at = _linearised(started, hypothesis, states, strengths, pool)
    poor = 0
    for _ in range(_MOST_STEPS):
        common, predicted = _common_step(at, hypothesis.size)
        before = _chi2(at)
        if before - _HOPE * predicted > worth or (poor >= _MOST_POOR and before > worth):
            break
        if predicted < _SETTLED * max(1.0, _chi2(at) / sum(s.dof for s in started)):
            break
        better = _line_search(started, hypothesis, states, strengths, at, common, pool)
        if better is None:
            break
        states, strengths, at = better
        poor = poor + 1 if before - _chi2(at) < _POOR * predicted else 0
    return JointFit(started, hypothesis, tuple(states), strengths, _covariance(at, hypothesis.size), tuple(at))


def starting_strengths(at: JointFit, hypothesis: Hypothesis) -> np.ndarray:
    """Strengths of a refit as a beginning for another hypothesis; 0 for what is new."""
    known = {c.key: at.strengths[s] for c, s in zip(at.hypothesis.common, at.hypothesis.slices, strict=True)}
    out = np.zeros(hypothesis.size)
    for c, s in zip(hypothesis.common, hypothesis.slices, strict=True):
        if c.key in known:
            out[s] = known[c.key]
    return out


def starting_point(at: JointFit, hypothesis: Hypothesis) -> tuple[list[FitState], np.ndarray]:
    """States and strengths of a refit as a beginning for another hypothesis.

    Effects that it lacks, and losses that it holds at 0, are taken up by everything else as well as that can, to first
    order: left where it was, the rest would describe another motion.
    """
    keys, held = {c.key for c in hypothesis.common}, [3 + k for k in hypothesis.gone if k not in at.hypothesis.gone]
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
    states = [_at_zero(s.moved(a.own_step(common)), hypothesis.gone) for s, a in zip(at.states, rest, strict=True)]
    return states, starting_strengths(replace(at, strengths=strengths), hypothesis)


def _at_zero(state: FitState, gone: Sequence[int]) -> FitState:
    """The state with these losses at 0."""
    values = tuple(0.0 if k in gone else q for k, q in enumerate(state.dynamics.values))
    return replace(state, dynamics=replace(state.dynamics, values=values))


def _linearised(
    started: Sequence[PreparedShot],
    hypothesis: Hypothesis,
    states: Sequence[FitState],
    strengths: Array,
    pool: Executor,
) -> list[LinearisedShot]:
    """All shots at their states."""

    def one(start: PreparedShot, state: FitState) -> LinearisedShot:
        return linearise_shot(start, hypothesis, state, strengths)

    return list(pool.map(one, started, states))


def _chi2(at: Sequence[LinearisedShot]) -> float:
    return sum(a.chi2 for a in at)


def _common_step(at: Sequence[LinearisedShot], size: int) -> tuple[Array, float]:
    """Best step of the common strengths, and the fall of chi^2 it brings together with the shots' own steps."""
    matrix, gradient = common_information(at, size)
    step = solved(matrix, gradient)
    own = sum(float(np.sum((a.q.T @ a.residual) ** 2)) for a in at)
    return step, float(gradient @ step) + own


def _covariance(at: Sequence[LinearisedShot], size: int) -> Array:
    return inverse(common_information(at, size)[0]) if size else np.zeros((0, 0))


def _line_search(
    started: Sequence[PreparedShot], hypothesis: Hypothesis, states: Sequence[FitState], strengths: Array,
    at: list[LinearisedShot], common: Array, pool: Executor,
) -> _There | None:  # fmt: skip
    """The longest of ever shorter steps that goes down, or None.

    The valley of an effect that the shots' own parameters can nearly follow is narrow and bent: a good step along it
    leaves it sideways. After a step that goes up, the shots' own parameters may therefore find back at the new
    strengths, and at last all together, before it is judged.
    """
    before = _chi2(at)
    fraction = 1.0
    while fraction > _SMALLEST:
        there = _stepped(started, hypothesis, states, strengths, at, fraction, common, pool)
        if there is not None and _chi2(there[2]) >= before:
            there = _back(started, hypothesis, there, before, pool)
        if there is not None and _chi2(there[2]) < before:
            return there
        fraction *= 0.3
    return None


def _back(
    started: Sequence[PreparedShot], hypothesis: Hypothesis, there: _There, before: float, pool: Executor
) -> _There | None:
    """After steps of the shots' own parameters at given strengths, as long as they go down, and one of all together."""
    nothing = np.zeros(hypothesis.size)
    for _ in range(_BACK):
        nearer = _stepped(started, hypothesis, *there, 1.0, nothing, pool)
        if nearer is None or _chi2(nearer[2]) >= _chi2(there[2]):
            break
        there = nearer
        if _chi2(there[2]) < before:
            return there
    common, _ = _common_step(there[2], hypothesis.size)
    return _stepped(started, hypothesis, *there, 1.0, common, pool)


def _stepped(
    started: Sequence[PreparedShot], hypothesis: Hypothesis, states: Sequence[FitState], strengths: Array,
    at: list[LinearisedShot], fraction: float, common: Array, pool: Executor,
) -> _There | None:  # fmt: skip
    """After a fraction of a step; None where nothing oscillates."""
    moved = [s.moved(fraction * a.own_step(common)) for s, a in zip(states, at, strict=True)]
    there = strengths + fraction * common
    try:
        return moved, there, _linearised(started, hypothesis, moved, there, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None

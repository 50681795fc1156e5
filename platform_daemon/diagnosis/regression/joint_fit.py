"""Joint fit of several shots: every shot keeps its declared parameters, effects have common strengths.

Gauss-Newton from fits of the declared model. Torque effects are in the equation of motion, receiver effects change
the model's channels (Candidate.change), additive effects are linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr, solve_triangular

from platform_daemon.estimation import Array, FitState, LostTrajectoryError

from ..shots.linearisation import Linearisation, linearise_signal
from ..shots.shot import PreparedShot
from .hypothesis import Hypothesis
from .information import inverse, solved

_MOST_STEPS = 12
_SETTLED = 0.02  # fall of chi^2 that a further step would bring
_SMALLEST = 1e-3  # fraction of a step
_BACK = 3  # steps of the shots' own parameters back into the valley
_NOTHING = 1e-9  # share of a column that must be left beside the others


@dataclass(frozen=True)
class LinearisedShot:
    """One shot at one state: its own parameters in triangular form, the common strengths beside them.

    Attributes:
        seen: the look.
        own: orthonormal columns of the additive effects that the shot has for itself, (rows, k).
        q, triangle, scale: factors of the declared parameters' scaled columns beside `own`.
        free: bool (p,) which of the declared parameters these are; the others are held.
        columns: (rows, common) of the common strengths beside `own`.
        residual: (rows,) beside `own`.
    """

    seen: Linearisation
    own: Array
    q: Array
    triangle: Array
    scale: Array
    free: np.ndarray
    columns: Array
    residual: Array

    @property
    def chi2(self) -> float:
        """Of the residual as it is."""
        return float(self.residual @ self.residual)

    @property
    def parameters(self) -> int:
        """Of this shot alone."""
        return int(self.q.shape[1] + self.own.shape[1])

    def beside(self, columns: Array) -> Array:
        """Columns (rows, ...) without what lies within the shot's own parameters."""
        for _ in range(2):
            columns = columns - self.own @ (self.own.T @ columns)
            columns = columns - self.q @ (self.q.T @ columns)
        return columns

    def projected(self, columns: Array) -> tuple[Array, Array, Array]:
        """Of columns (k, rows) beside the shot's own parameters: information (k, k), gradient, power (k,)."""
        inside = np.concatenate([columns @ self.own, columns @ self.q], axis=1)
        whole = columns @ columns.T
        gradient = columns @ self.residual - inside[:, self.own.shape[1] :] @ (self.q.T @ self.residual)
        return whole - inside @ inside.T, gradient, np.diag(whole).copy()

    def own_step(self, common: Array) -> Array:
        """Best step of the declared parameters beside a step of the common strengths."""
        target = self.q.T @ (self.residual - self.columns @ common)
        step = np.zeros(self.free.size)
        step[self.free] = solve_triangular(self.triangle, target) * self.scale
        return step

    def own_covariance(self) -> Array:
        """Of the declared parameters at fixed common strengths, (p, p); 0 for those held."""
        inverse = solve_triangular(self.triangle, np.eye(self.triangle.shape[0])) * self.scale[:, None]
        out = np.zeros((self.free.size, self.free.size))
        out[np.ix_(self.free, self.free)] = inverse @ inverse.T
        return out

    def base(self) -> Array:
        """Columns of the declared parameters, (rows, p); 0 for those held."""
        out = np.zeros((self.q.shape[0], self.free.size))
        out[:, self.free] = (self.q @ self.triangle) / self.scale
        return out


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
    def noise_factor(self) -> float:
        """By how much gains of chi^2 are to be divided where the noise is larger than was measured."""
        return max(1.0, self.chi2 / self.dof)

    def full_state(self, k: int) -> FitState:
        """Of shot k, with the torque strengths among its coefficients."""
        return self.hypothesis.extended(self.states[k], self.strengths)


def fit_jointly(
    started: Sequence[PreparedShot],
    hypothesis: Hypothesis,
    pool: Executor,
    states: Sequence[FitState] | None = None,
    guess: Array | None = None,
) -> JointFit:
    """Minimise chi^2 of all shots.

    states: of the declared model, to begin at; None: as the shots were started. guess: strengths (q,); None: 0.

    Raises:
        LostTrajectoryError: a state does not oscillate.
    """
    strengths = np.zeros(hypothesis.size) if guess is None else np.asarray(guess, dtype=np.float64)
    states = [s.state for s in started] if states is None else list(states)
    at = _linearised(started, hypothesis, states, strengths, pool)
    for _ in range(_MOST_STEPS):
        common, predicted = _common_step(at, hypothesis.size)
        if predicted < _SETTLED * max(1.0, _chi2(at) / sum(s.dof for s in started)):
            break
        better = _line_search(started, hypothesis, states, strengths, at, common, pool)
        if better is None:
            break
        states, strengths, at = better
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
    rest = [_lacking(a, s, held, np.where(kept, 0.0, at.strengths), kept) for s, a in pairs]
    common, _ = _common_step(rest, int(kept.sum()))
    strengths = at.strengths.copy()
    strengths[kept] += common
    states = [_at_zero(s.moved(a.own_step(common)), hypothesis.gone) for s, a in zip(at.states, rest, strict=True)]
    return states, starting_strengths(replace(at, strengths=strengths), hypothesis)


def _at_zero(state: FitState, gone: Sequence[int]) -> FitState:
    """The state with these losses at 0."""
    values = tuple(0.0 if k in gone else q for k, q in enumerate(state.dynamics.values))
    return replace(state, dynamics=replace(state.dynamics, values=values))


def _lacking(a: LinearisedShot, state: FitState, held: Sequence[int], gone: Array, kept: np.ndarray) -> LinearisedShot:
    """One shot without some declared parameters (their places `held`) and common strengths, as if these were 0.

    gone (common,): the strengths that are to become 0; kept bool (common,): those that stay in play.
    """
    base, free = a.base(), a.free.copy()
    free[held] = False
    values = np.array([state.dynamics.values[k - 3] for k in held])
    residual = a.residual + base[:, held] @ values + a.columns @ gone
    return LinearisedShot(a.seen, a.own, *_factors(base[:, free]), free, a.columns[:, kept], residual)


def linearise_shot(started: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array) -> LinearisedShot:
    """One shot at a state of the declared model with the strengths put in.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    full = hypothesis.extended(state, strengths)
    seen = hypothesis.through(linearise_signal(started, hypothesis.augmented, full), strengths)
    shared = hypothesis.shared_columns(seen)
    base, torques = hypothesis.torque_rows(state, strengths, seen.base)
    columns, base = np.concatenate([torques, shared]).T, base.T
    residual = seen.whitened - hypothesis.additive_part(strengths, shared)
    free = hypothesis.free(base.shape[1])
    base = base[:, free]
    own = _orthonormal(hypothesis.own_columns(seen).T)
    if own.shape[1]:
        base, columns, residual = (x - own @ (own.T @ x) for x in (base, columns, residual))
    return LinearisedShot(seen, own, *_factors(base), free, columns, residual)


def _factors(base: Array) -> tuple[Array, Array, Array]:
    """Orthonormal columns, triangle and scale of the columns of parameters."""
    norm = np.linalg.norm(base, axis=0)
    scale = 1.0 / np.where(norm > 0.0, norm, 1.0)
    q, triangle = (np.asarray(x, dtype=np.float64) for x in qr(base * scale, mode="economic"))
    return q, triangle, scale


def _orthonormal(columns: Array) -> Array:
    """Orthonormal columns that span the same space."""
    if columns.shape[1] == 0:
        return columns
    norm = np.linalg.norm(columns, axis=0)
    q, triangle, _ = qr(columns / np.where(norm > 0.0, norm, 1.0), mode="economic", pivoting=True)
    size = np.abs(np.diag(triangle))
    return np.asarray(q[:, size > _NOTHING * max(size[0], _NOTHING)])


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


def _information(at: Sequence[LinearisedShot], size: int) -> tuple[Array, Array]:
    """Matrix and gradient of the common strengths beside everything that the shots have for themselves."""
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    for a in at:
        rest = a.columns - a.q @ (a.q.T @ a.columns)
        matrix += rest.T @ rest
        gradient += rest.T @ a.residual
    return matrix, gradient


def _common_step(at: Sequence[LinearisedShot], size: int) -> tuple[Array, float]:
    """Best step of the common strengths, and the fall of chi^2 it brings together with the shots' own steps."""
    matrix, gradient = _information(at, size)
    step = solved(matrix, gradient)
    own = sum(float(np.sum((a.q.T @ a.residual) ** 2)) for a in at)
    return step, float(gradient @ step) + own


def _covariance(at: Sequence[LinearisedShot], size: int) -> Array:
    return inverse(_information(at, size)[0]) if size else np.zeros((0, 0))


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

"""Joint fit of several shots: every shot keeps its declared parameters, effects have one strength for all.

Gauss-Newton from fits of the declared model. Effects of the receive side are taken out of the data (Candidate.undo)
and torque effects are in the equation of motion, so that both are exact at any strength.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import qr, solve_triangular

from platform_daemon.estimation.arrays import Array
from platform_daemon.estimation.gauss_newton import FitState
from platform_daemon.estimation.trajectory import LostTrajectoryError

from .hypothesis import Hypothesis
from .look import Look, look
from .shots import Grid, Shot

_MOST_STEPS = 12
_SETTLED = 0.02  # fall of chi^2 that a further step would bring
_SMALLEST = 1e-3  # fraction of a step


@dataclass(frozen=True)
class Started:
    """A shot with its fitted state of the declared model, and its grids."""

    shot: Shot
    state: FitState
    grids: tuple[Grid, ...]


@dataclass(frozen=True)
class Refit:
    """A joint minimum.

    states: of every shot, with the torque strengths among the coefficients. strengths (q,) and their covariance (q, q)
    in the order of hypothesis.effects; own: covariances of the declared parameters of every shot at fixed strengths.
    """

    hypothesis: Hypothesis
    states: tuple[FitState, ...]
    strengths: Array
    covariance: Array
    chi2: float
    dof: int
    looks: tuple[Look, ...]


@dataclass(frozen=True)
class _Linear:
    """One shot at one state: triangular factor of its declared parameters, rotated columns and residual."""

    seen: Look
    triangle: Array
    scale: Array
    along: Array  # (p, q) columns within the span of the declared parameters
    rest: Array  # (N, q) and beside it
    target: Array  # (p,) residual within the span
    beside: Array  # (N,)

    @property
    def chi2(self) -> float:
        """Of the residual as it is."""
        return float(self.seen.whitened @ self.seen.whitened)

    def own_step(self, shared: Array) -> Array:
        """Best step of the declared parameters beside a step of the strengths."""
        return np.asarray(solve_triangular(self.triangle, self.target - self.along @ shared)) * self.scale


def refit(started: Sequence[Started], hypothesis: Hypothesis, pool: Executor, guess: Array | None = None) -> Refit:
    """Minimise chi^2 of all shots, beginning at the strengths `guess` (q,), or at 0.

    Raises:
        LostTrajectoryError: a state does not oscillate.
    """
    strengths = np.zeros(hypothesis.size) if guess is None else np.asarray(guess, dtype=np.float64)
    states = [s.state for s in started]
    at = _linearised(started, hypothesis, states, strengths, pool)
    for _ in range(_MOST_STEPS):
        shared, predicted = _shared_step(at, hypothesis.size)
        if predicted < _SETTLED:
            break
        better = _line_search(started, hypothesis, states, strengths, at, shared, pool)
        if better is None:
            break
        states, strengths, at = better
    return _result(hypothesis, states, strengths, at)


def _linearised(
    started: Sequence[Started], hypothesis: Hypothesis, states: Sequence[FitState], strengths: Array, pool: Executor
) -> list[_Linear]:
    """All shots at their states."""
    work = partial(_one, hypothesis, strengths)
    return list(pool.map(work, started, states))


def _one(hypothesis: Hypothesis, strengths: Array, started: Started, state: FitState) -> _Linear:
    """One shot at a state of the declared model with the strengths put in."""
    full = hypothesis.extended(state, strengths)
    seen = look(started.shot, hypothesis.freed(started.shot, strengths), hypothesis.augmented, full, started.grids)
    base = seen.base[hypothesis.declared(full.size)]
    torque = seen.base[list(hypothesis.strength_places)]
    signal = [seen.white(c.columns(seen)) for c in hypothesis.signals if c.columns is not None]
    columns = np.concatenate([torque, *signal]).T
    norm = np.linalg.norm(base, axis=1)
    scale = 1.0 / np.where(norm > 0.0, norm, 1.0)
    q, triangle = qr((base * scale[:, None]).T, mode="economic")
    along = q.T @ columns
    target = q.T @ seen.whitened
    return _Linear(seen, triangle, scale, along, columns - q @ along, target, seen.whitened - q @ target)


def _shared_step(at: Sequence[_Linear], size: int) -> tuple[Array, float]:
    """Best step of the strengths, and the fall of chi^2 it brings together with the shots' own steps."""
    information = sum((a.rest.T @ a.rest for a in at), np.zeros((size, size)))
    gradient = sum((a.rest.T @ a.beside for a in at), np.zeros(size))
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    step = scale * np.linalg.lstsq(information * np.outer(scale, scale), gradient * scale, rcond=1e-13)[0]
    return step, float(gradient @ step + sum(a.target @ a.target for a in at))


def _line_search(
    started: Sequence[Started], hypothesis: Hypothesis, states: Sequence[FitState], strengths: Array,
    at: list[_Linear], shared: Array, pool: Executor,
) -> tuple[list[FitState], Array, list[_Linear]] | None:  # fmt: skip
    """The longest of ever shorter steps that goes down, or None."""
    before = sum(a.chi2 for a in at)
    fraction = 1.0
    while fraction > _SMALLEST:
        moved = [_moved(hypothesis, s, fraction * a.own_step(shared)) for s, a in zip(states, at, strict=True)]
        there = strengths + fraction * shared
        try:
            trial = _linearised(started, hypothesis, moved, there, pool)
        except LostTrajectoryError:
            trial = []
        if trial and sum(a.chi2 for a in trial) < before:
            return moved, there, trial
        fraction *= 0.3
    return None


def _moved(hypothesis: Hypothesis, state: FitState, own: Array) -> FitState:
    """A state of the declared model after a step of its own parameters."""
    return state.moved(own)


def _result(hypothesis: Hypothesis, states: Sequence[FitState], strengths: Array, at: Sequence[_Linear]) -> Refit:
    size = hypothesis.size
    information = sum((a.rest.T @ a.rest for a in at), np.zeros((size, size)))
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    covariance = np.linalg.pinv(information * np.outer(scale, scale)) * np.outer(scale, scale) if size else information
    count = sum(a.beside.size - a.triangle.shape[0] for a in at) - size
    return Refit(
        hypothesis=hypothesis,
        states=tuple(hypothesis.extended(s, strengths) for s in states),
        strengths=strengths,
        covariance=covariance,
        chi2=sum(a.chi2 for a in at),
        dof=count,
        looks=tuple(a.seen for a in at),
    )

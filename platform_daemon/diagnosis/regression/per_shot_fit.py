"""Fit of one shot's own parameters with the common strengths held."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .hypothesis import Hypothesis
from .linearised_shot import LinearisedShot, linearise_shot

_LIMITS = THRESHOLDS.regression


def per_shot_fit(
    prepared: PreparedShot, hypothesis: Hypothesis, strengths: Array, *, near: FitState | None = None
) -> tuple[LinearisedShot, FitState]:
    """The shot at its best state, and that state.

    The initial fit knows none of the effects.  Where these move the motion by more than a fraction of a turn, as a
    frequency that settles does over a long ring-down, no step leads from there.  Where the shot is left worse than by
    the declared model, and with more than noise, the effects therefore grow in ever more parts, and each part begins
    with the state of the one before.

    Args:
        prepared: with the state of the initial fit.
        hypothesis, strengths: the effects, and their common strengths (q,), held.
        near: a state from which the fit starts before it starts from the initial one.

    Raises:
        LostTrajectoryError: none of these states oscillates.
    """
    if not strengths.any():
        return _settled(prepared, hypothesis, prepared.state, strengths)
    without = linearise_shot(prepared, hypothesis, prepared.state, np.zeros_like(strengths)).chi2
    enough = max(without, THRESHOLDS.regression.noise_chi2_per_dof * prepared.dof)
    found = list[tuple[LinearisedShot, FitState]]()
    for start in () if near is None else (near,):
        with suppress(LostTrajectoryError):
            found.append(_settled(prepared, hypothesis, start, strengths))
    for parts in (1, *_LIMITS.per_shot_parts):
        if found and min(one.chi2 for one, _ in found) < enough:
            break
        with suppress(LostTrajectoryError):
            found.append(_grown(prepared, hypothesis, strengths, parts))
    if not found:
        raise LostTrajectoryError("with the effects the shot does not oscillate")
    return min(found, key=lambda one: one[0].chi2)


def _grown(
    prepared: PreparedShot, hypothesis: Hypothesis, strengths: Array, parts: int
) -> tuple[LinearisedShot, FitState]:
    """With effects that grow in so many parts.  Raises LostTrajectoryError."""
    found, state = None, prepared.state
    for part in range(1, parts + 1):
        found = _settled(prepared, hypothesis, state, part / parts * strengths)
        state = found[1]
    assert found is not None
    return found


def _settled(
    prepared: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array
) -> tuple[LinearisedShot, FitState]:
    """From a state down, by steps that are shortened where they lead up.  Raises LostTrajectoryError."""
    nothing = np.zeros(hypothesis.size)
    linear = linearise_shot(prepared, hypothesis, state, strengths)
    for _ in range(_LIMITS.per_shot_steps):
        lower = _lower(prepared, hypothesis, state, strengths, linear, nothing)
        if lower is None:
            break
        fall = linear.chi2 - lower[0].chi2
        linear, state = lower
        if fall < _LIMITS.per_shot_settled_chi2 * max(1.0, linear.chi2 / prepared.dof):
            break
    return linear, state


def _lower(
    prepared: PreparedShot,
    hypothesis: Hypothesis,
    state: FitState,
    strengths: Array,
    linear: LinearisedShot,
    nothing: Array,
) -> tuple[LinearisedShot, FitState] | None:
    """Where the longest of ever shorter steps ends that leads down; None where none does."""
    step, fraction = linear.own_step(nothing), 1.0
    while fraction > _LIMITS.smallest_fraction:
        moved = state.moved(fraction * step)
        with suppress(LostTrajectoryError):
            trial = linearise_shot(prepared, hypothesis, moved, strengths)
            if trial.chi2 < linear.chi2:
                return trial, moved
        fraction *= _LIMITS.shortening
    return None

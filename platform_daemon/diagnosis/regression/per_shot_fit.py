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
    frequency that settles does over a long ring-down, no step leads from there: where the fit begins near nothing
    better, the effects then grow in ever more parts, and each part begins with the state of the one before.

    Args:
        prepared: with the state of the initial fit, from which the fit starts.
        hypothesis, strengths: the effects, and their common strengths (q,), held.
        near: another state from which it starts first.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    found = _settled(prepared, hypothesis, prepared.state if near is None else near, strengths)
    if not strengths.any():
        return found
    without = linearise_shot(prepared, hypothesis, prepared.state, np.zeros_like(strengths)).chi2
    for parts in _LIMITS.per_shot_parts:
        if found[0].chi2 < without:
            break
        state = prepared.state
        with suppress(LostTrajectoryError):
            for share in (*np.linspace(0.0, 1.0, parts + 1)[1:], 1.0):  # the last part twice, to settle
                grown = _settled(prepared, hypothesis, state, share * strengths)
                state = grown[1]
            found = min(found, grown, key=lambda one: one[0].chi2)
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

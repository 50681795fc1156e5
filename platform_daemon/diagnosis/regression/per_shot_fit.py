"""Fit of one shot's own parameters with the common strengths held."""

from __future__ import annotations

import numpy as np

from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .hypothesis import Hypothesis
from .linearised_shot import LinearisedShot, linearise_shot

_LIMITS = THRESHOLDS.regression


def per_shot_fit(prepared: PreparedShot, hypothesis: Hypothesis, strengths: Array) -> tuple[LinearisedShot, FitState]:
    """The shot at its best state, and that state; the fit starts from the state of the initial fit.

    strengths: (q,) common strengths of the hypothesis, held.  Raises LostTrajectoryError.
    """
    state, nothing = prepared.state, np.zeros(hypothesis.size)
    linear = linearise_shot(prepared, hypothesis, state, strengths)
    for _ in range(_LIMITS.per_shot_steps):
        moved = state.moved(linear.own_step(nothing))
        try:
            trial = linearise_shot(prepared, hypothesis, moved, strengths)
        except LostTrajectoryError:
            break
        if trial.chi2 >= linear.chi2:
            break
        fall, linear, state = linear.chi2 - trial.chi2, trial, moved
        if fall < _LIMITS.per_shot_settled_chi2 * max(1.0, linear.chi2 / prepared.dof):
            break
    return linear, state

"""One shot's own fit, with the common strengths held."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation import Array, FitState, LostTrajectoryError

from ..shots.shot import PreparedShot
from .hypothesis import Hypothesis
from .linearised_shot import LinearisedShot, linearise_shot

_MOST_STEPS = 8
_SETTLED = 0.05  # of chi^2


def own_fit(started: PreparedShot, hypothesis: Hypothesis, strengths: Array) -> tuple[LinearisedShot, FitState]:
    """The shot at the best state of its own parameters (strengths (q,) of the hypothesis), begun where it was started.

    Raises LostTrajectoryError.
    """
    state, nothing = started.state, np.zeros(hypothesis.size)
    linear = linearise_shot(started, hypothesis, state, strengths)
    for _ in range(_MOST_STEPS):
        moved = state.moved(linear.own_step(nothing))
        try:
            trial = linearise_shot(started, hypothesis, moved, strengths)
        except LostTrajectoryError:
            break
        if trial.chi2 >= linear.chi2:
            break
        fall, linear, state = linear.chi2 - trial.chi2, trial, moved
        if fall < _SETTLED:
            break
    return linear, state

"""Scores of a moving f_nat come from the model's own derivatives: they must be what integrating the motion gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.effects.torque import drift_candidate, settling_candidate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.score_test import candidate_columns
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import model_named
from tests.kit.undeclared_shots import shots_with


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_the_column_of_a_moving_f_nat_is_that_of_its_torque(variant: str) -> None:
    shots, _ = shots_with(variant, count=1)
    model = model_named(variant)
    seconds = shots[0].record.samples.shape[1] / shots[0].rate_hz
    quick = settling_candidate(seconds).at_scale
    assert quick is not None
    moving = [drift_candidate(), settling_candidate(seconds), quick(40.0 / seconds)]
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, model, pool)
        base = fit_jointly(prepared, Hypothesis(model), pool)
    columns = [
        candidate_columns(prepared[0], base.hypothesis, base, 0, some)
        for some in (moving, [replace(c, f_nat_course=None) for c in moving])
    ]
    for by_course, traced in zip(*columns, strict=True):
        beside = base.linear[0].without_own(traced)
        assert np.linalg.norm(base.linear[0].without_own(by_course) - beside) < 2e-5 * np.linalg.norm(beside)

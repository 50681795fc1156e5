"""Errors of the parameters where the declared model leaves more than noise."""

import math

import pytest

from platform_daemon.diagnosis.diagnose import candidates_for
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.parameters import means
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with


@pytest.mark.long
def test_what_is_left_beside_a_model_widens_the_errors_of_its_parameters():
    shots, truths = shots_with("thread", [{"id": "coulomb_friction", "strength": 30.0}], count=1)
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, THREAD, pool)
        base = fit_jointly(prepared, Hypothesis(THREAD), pool)
        friction = next(c for c in candidates_for(base) if c.effect.id == "coulomb_friction")
        whole = fit_jointly(prepared, base.hypothesis.plus(friction), pool, base.states)
    assert base.chi2_per_dof > 2.0
    assert whole.chi2_per_dof < 1.02
    before, after = means(base)["f_nat_hz"], means(whole)["f_nat_hz"]
    assert before.std > math.sqrt(base.chi2_per_dof) * 0.5 * after.std
    assert abs(before.value - truths[0]["f_nat_hz"]) < 5.0 * before.std

"""What is surely there and small beside an effect that was named."""

import pytest

from platform_daemon.diagnosis.effect_search import candidates_for
from platform_daemon.diagnosis.findings.negligible_effects import negligible_effects
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with

STRONG = {"id": "angle_dependent_damping", "strength": 0.25}
WEAK = {"id": "bias_torque", "strength": 14000.0}


@pytest.mark.parametrize("effects", [[STRONG, WEAK], [STRONG]], ids=["something", "nothing"])
def test_what_a_search_passes_over_is_found_by_a_refit_and_nothing_where_nothing_is(effects):
    pool = InlineExecutor()
    shots, _ = shots_with("thread", effects, count=2, rx_s=1.0, seed=5)
    prepared, _ = initial_fits(shots, THREAD, pool)
    base = fit_jointly(prepared, Hypothesis(THREAD), pool)
    offered = candidates_for(base)
    (named,) = (c for c in offered if c.effect.id == STRONG["id"])
    final = fit_jointly(prepared, Hypothesis(THREAD).plus(named), pool)
    seen = score_table(final, [c for c in offered if c is not named and c.term is not None and not c.term.timed], pool)
    found = negligible_effects(seen, (), float(len(offered)), pool)
    assert bool(found) == (WEAK in effects)
    if found:
        assert found[0].candidate.effect.id == "bias_torque"
        assert found[0].joint_fit.strengths[-1] != 0.0
        assert "bias_torque gains" in found[0].note
        left = negligible_effects(seen, [one.candidate for one in found], float(len(offered)), pool)
        assert all(one.candidate.effect.id != "bias_torque" for one in left)

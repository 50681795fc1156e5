"""Two torques that would do in the place of the one that was named."""

import pytest

from platform_daemon.diagnosis.effect_search import candidates_for
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.selection.confounders import confounders, two_in_place
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with

HERTZ = {"id": "hertz_friction", "strength": 150.0}
DAMPING = {"id": "angle_dependent_damping", "strength": 0.1}
COULOMB = {"id": "coulomb_friction", "strength": 150.0}


@pytest.mark.parametrize(
    "effects",
    [pytest.param([HERTZ, DAMPING], id="two"), pytest.param([COULOMB], id="one", marks=pytest.mark.campaign)],
)
def test_two_that_fit_better_are_told_and_one_that_is_right_stands_alone(effects):
    pool = InlineExecutor()
    shots, _ = shots_with("thread", effects, count=2, rx_s=1.5, seed=3)
    prepared, _ = initial_fits(shots, THREAD, pool)
    base = fit_jointly(prepared, Hypothesis(THREAD), pool)
    offered = [c for c in candidates_for(base) if c.term is not None and not c.term.timed and not c.hidden]
    (named,) = (c for c in offered if c.effect.id == "coulomb_friction")
    final = fit_jointly(prepared, Hypothesis(THREAD).plus(named), pool)
    seen = score_table(final, [c for c in offered if c is not named], pool)
    alone = confounders(seen, named, pool)
    print([(r.candidate.effect.id, round(r.rise, 1)) for r in alone])
    pairs = two_in_place(seen, named, alone, pool)
    print([(r.candidate.effect.id, r.second.effect.id, round(r.rise, 1)) for r in pairs])
    assert bool(pairs) == (len(effects) == 2)
    assert all(r.candidate.effect.id == "hertz_friction" and r.indistinguishable for r in pairs)

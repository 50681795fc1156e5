"""A kick must show in the few periods around its instant."""

import numpy as np
import pytest

from platform_daemon.diagnosis.effect_search import candidates_for
from platform_daemon.diagnosis.effects.kick import moved_kick
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.selection.kick_search import kick_missing, kicks
from platform_daemon.diagnosis.selection.refits import refined, refit
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import RATE, kicked, swing


def with_a_kick(angle, noise=3e-4):
    """The declared model with the likeliest kick, fitted to an angle."""
    read = angle + np.random.default_rng(1).normal(0.0, noise, angle.size)
    record, pool = RingDownRecord(read[None], RATE, "angle"), InlineExecutor()
    prepared, _ = initial_fits([DiagnosisShot("swing", record, estimate_noise(record))], THREAD, pool)
    base = fit_jointly(prepared, Hypothesis(THREAD), pool)
    fitted = refit(base.hypothesis.plus(kicks(base)[0]), base, pool)
    assert fitted is not None
    return base, refined(fitted, pool)


@pytest.mark.parametrize("change", [1e-3, pytest.param(2e-2, marks=pytest.mark.long)])
def test_a_kick_shows_at_its_instant(change):
    assert not kick_missing(with_a_kick(kicked(0.8, 15.0, at_period=7.3, change=change))[1])


def test_what_friction_is_wrong_by_is_no_kick():
    base, fitted = with_a_kick(swing(0.8, 15.0, dry=0.004))
    assert fitted.chi2 < 0.8 * base.chi2
    assert kick_missing(fitted)


def test_the_score_of_a_torque_beside_a_large_kick_is_what_its_refit_gains():
    """Of the swing that was kicked: the columns of the other one promise something else."""
    base, fitted = with_a_kick(kicked(1.2, 30.0, at_period=9.3, change=0.25, dry=3e-4), noise=3e-3)
    coulomb = next(c for c in candidates_for(base) if c.effect.id == "coulomb_friction")
    pool = InlineExecutor()
    table = score_table(fitted, [coulomb], pool)
    promised = table.gain(table.blocks)
    gained = refit(fitted.hypothesis.plus(coulomb), fitted, pool)
    fall = (fitted.chi2 - gained.chi2) / gained.noise_factor
    assert fall > 100.0
    assert promised.gain == pytest.approx(fall, rel=0.1)


def test_a_large_kick_beside_a_torque_of_time_is_refused_and_a_small_one_counts_to_first_order():
    base, large = with_a_kick(kicked(1.2, 20.0, at_period=7.3, change=0.25), noise=3e-3)
    _, small = with_a_kick(kicked(1.2, 20.0, at_period=7.3, change=3e-3), noise=3e-4)
    drift = next(c for c in candidates_for(base) if c.effect.id == "frequency_drift")
    pool = InlineExecutor()
    assert refit(large.hypothesis.plus(drift), large, pool) is None
    spring = next(c for c in candidates_for(base) if c.effect.id == "cubic_restoring")
    beside_spring = refit(large.hypothesis.plus(spring), large, pool)  # there drifts are linearised by themselves
    table = score_table(beside_spring, [drift], pool)
    assert table.gain(table.blocks) is None
    beside = refit(small.hypothesis.plus(drift), small, pool)
    assert beside.chi2 < small.chi2 + 0.05 * small.dof


def test_a_kick_stays_where_it_can_be_told_from_start_and_end():
    _, fitted = with_a_kick(kicked(0.8, 15.0, at_period=7.3, change=1e-3))
    (found,) = fitted.hypothesis.effects
    linearisation = fitted.linear[0].linearisation
    assert 0.7 < moved_kick(found, -100.0, linearisation).kick_at_s < 0.8  # 1.5 periods of 0.5 s
    assert moved_kick(found, 100.0, linearisation).kick_at_s < linearisation.time_s[-1] - 0.7

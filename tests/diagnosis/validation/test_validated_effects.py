"""Which effects of a search are still there once all of them are known."""

import math

import numpy as np
import pytest

from platform_daemon.diagnosis.effects.additive import LINE, tone
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.selection.refits import refit
from platform_daemon.diagnosis.selection.stepwise import StepwiseSearch
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.diagnosis.validation.validated_effects import log_chance_of, validate_effects
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import RATE, swing

POOL = InlineExecutor()
TRIALS = 100.0
THERE, NOT_THERE, IN_THE_SWING = (tone(LINE, (f,), f, TRIALS) for f in (23.0, 37.0, 1.95))


@pytest.fixture(scope="module")
def found():
    """A search that ended with a line that the shot has, one that it has not, and one that stood for the swing."""
    angle, sd = swing(0.5, 24.0), 1e-4
    line = 0.5 * sd * np.cos(2.0 * math.pi * 23.0 * np.arange(angle.size) / RATE)
    read = angle + line + np.random.default_rng(3).normal(0.0, sd, angle.size)
    record = RingDownRecord(read[None], RATE, "angle")
    shot = DiagnosisShot("swing", record, NoiseModel.white(np.array([sd]), RATE))
    prepared, _ = initial_fits([shot], THREAD, POOL)
    base = fit_jointly(prepared, Hypothesis(THREAD), POOL)
    search = StepwiseSearch(base, [], POOL, lambda *_: None)
    return search.run(refit(base.hypothesis.plus(THERE).plus(NOT_THERE).plus(IN_THE_SWING), base, POOL))


def test_a_line_that_is_not_there_is_likely_noise(found):
    assert log_chance_of(found.best, NOT_THERE, found, POOL) > math.log(0.05)
    assert log_chance_of(found.best, IN_THE_SWING, found, POOL) > math.log(0.05)
    assert log_chance_of(found.best, THERE, found, POOL) < math.log(1e-6)


def test_lines_that_are_no_longer_significant_are_dropped(found):
    assert {c.key for c in found.best.hypothesis.effects} == {THERE.key, NOT_THERE.key, IN_THE_SWING.key}
    table, *_ = validate_effects(found, POOL)
    assert [c.key for c in table.joint_fit.hypothesis.effects] == [THERE.key]

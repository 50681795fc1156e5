"""Three swings of one drag and another one: the strengths of each, and which is the odd one."""

import math

import numpy as np

from platform_daemon.diagnosis.effects.torque import torque_candidates
from platform_daemon.diagnosis.findings.shot_strengths import strengths_by_shot
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.selection.refits import refit
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, half_cycles

POOL = InlineExecutor()


def dragged(drag, seed):
    s = 2.0 * math.pi * NATURAL_HZ * np.arange(int(6 * RATE / NATURAL_HZ)) / RATE
    angle = half_cycles(lambda p, v, sigma, _: -math.sin(p) - 0.008 * v - drag * v * abs(v), 0.8, s, 1e-10)[0]
    record = RingDownRecord((angle + np.random.default_rng(seed).normal(0.0, 3e-4, s.size))[None], RATE, "angle")
    return DiagnosisShot(f"run {seed}", record, estimate_noise(record))


def with_drag(*drags):
    prepared, _ = initial_fits([dragged(drag, seed) for seed, drag in enumerate(drags)], THREAD, POOL)
    base = fit_jointly(prepared, Hypothesis(THREAD), POOL)
    drag = next(c for c in torque_candidates(THREAD) if c.effect.id == "quadratic_drag")
    found = refit(base.hypothesis.plus(drag), base, POOL)
    assert found is not None
    return found


def test_the_strength_of_each_shot_and_the_odd_one_are_told():
    found = strengths_by_shot(with_drag(0.03, 0.0301, 0.06), POOL)
    assert found is not None
    assert found.differ
    np.testing.assert_allclose(found.values[:, 0], [0.03, 0.0301, 0.06], rtol=0.1)
    assert "run 2 is the odd one" in found.notes[0]


def test_of_shots_that_are_alike_there_is_nothing_to_tell():
    assert strengths_by_shot(with_drag(0.03, 0.03), POOL) is None

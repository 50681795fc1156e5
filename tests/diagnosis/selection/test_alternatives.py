"""Sets of torques that a model's error does not exclude, and time in the place of the amplitude."""

import math

import numpy as np
import pytest

from platform_daemon.diagnosis.effects.torque import pendulum_candidates
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.selection.amplitude_laws import laws_of_amplitude, time_is_doubtful, timed_torques
from platform_daemon.diagnosis.selection.refits import refit
from platform_daemon.diagnosis.selection.torque_sets import alternatives
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, half_cycles

NOISE, POOL = 3e-4, InlineExecutor()


def roll(amplitude=0.6, periods=12, viscous=0.02, power=4.5, ripple=1.5e-3):
    """A swing whose spring stiffens with a power of the angle, 5 % at 0.6 rad, beside a ripple that has no name."""

    def torque(p, v, sigma, s):
        return -math.sin(p) - 0.05 * 0.6 * (abs(p) / 0.6) ** power * math.copysign(1.0, p) - 2.0 * viscous * v

    s = 2.0 * math.pi * NATURAL_HZ * np.arange(int(periods * RATE / NATURAL_HZ)) / RATE
    return half_cycles(torque, amplitude, s, 1e-10)[0] + ripple * np.sin(0.37 * s) * np.cos(1.9 * s)


def declared(*angles):
    """The declared model fitted to angles."""
    shots = []
    for k, angle in enumerate(angles):
        read = angle + np.random.default_rng(k).normal(0.0, NOISE, angle.size)
        record = RingDownRecord(read[None], RATE, "angle")
        shots.append(DiagnosisShot(f"swing {k}", record, estimate_noise(record)))
    prepared, _ = initial_fits(shots, THREAD, POOL)
    return fit_jointly(prepared, Hypothesis(THREAD), POOL)


@pytest.fixture(scope="module")
def one_swing():
    """The declared model fitted to one swing, and a fit by the id of each single torque."""
    base = declared(roll())
    torques = pendulum_candidates(THREAD, 8.0, 6.0, 0.6)
    chosen = [c for c in torques if c.effect.id in ("power_restoring", "cubic_restoring", "bias_torque")]
    chosen += [c for c in torques if c.effect.id == "frequency_drift" and c.hidden]
    found = {c.effect.id: refit(base.hypothesis.plus(c), base, POOL) for c in chosen}
    assert None not in found.values()
    return base, found


def test_of_one_swing_that_leaves_more_than_noise_time_is_doubtful(one_swing):
    _, fits = one_swing
    drift, law = fits["frequency_drift"], fits["power_restoring"]
    assert timed_torques(drift)
    assert time_is_doubtful(drift)
    assert laws_of_amplitude(law)
    assert not laws_of_amplitude(drift)


def test_of_swings_of_other_sizes_it_is_not():
    base = declared(roll(periods=6), roll(0.35, periods=6))
    assert base.chi2_per_dof > 1.1
    assert not time_is_doubtful(base)


def test_where_noise_alone_is_left_it_decides():
    base = declared(roll(0.02, periods=6, ripple=0.0))
    assert base.chi2_per_dof < 1.1
    assert not time_is_doubtful(base)


def test_sets_that_leave_little_more_are_alternatives_and_others_are_not(one_swing):
    base, fits = one_swing
    best = min(fits.values(), key=lambda f: f.chi2)
    others = alternatives(best, [base, *fits.values()])
    assert [f.chi2 for f in others] == sorted(
        f.chi2 for f in fits.values() if f is not best and f.chi2 < 1.5**2 * best.chi2
    )
    assert others
    assert fits["bias_torque"].chi2 > 1.5**2 * best.chi2


def test_a_drift_is_never_told_without_a_law_of_the_amplitude(one_swing):
    base, fits = one_swing
    few = [base, fits["frequency_drift"], fits["bias_torque"], fits["cubic_restoring"]]
    others = alternatives(fits["frequency_drift"], few)
    assert [f for f in others if laws_of_amplitude(f)] == [fits["cubic_restoring"]]

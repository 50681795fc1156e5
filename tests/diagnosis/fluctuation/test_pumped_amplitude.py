"""What a frequency does to the amplitude that is faster than the knots of its course, and noise beside its lines."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from platform_daemon.diagnosis.effect_search import candidates_for, declared_fit
from platform_daemon.diagnosis.fluctuation.flat_noise import with_flat_noise
from platform_daemon.diagnosis.fluctuation.fluctuating import what_may_fluctuate
from platform_daemon.diagnosis.fluctuation.process import CourseProcess
from platform_daemon.diagnosis.regression.linearised_shot import linearise_shot
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.linearisation import linearise_signal
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.diagnosis.shots.torque_course import CourseState, TorqueCourse
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import JEWEL
from tests.kit.undeclared_shots import shots_with

FRICTION, FREQUENCY = what_may_fluctuate(JEWEL)
PROCESS = CourseProcess(size=0.2, tau_s=0.1)
KNOTS = 20


@pytest.fixture(scope="module")
def prepared():
    shots, _ = shots_with("jewel", [], 1, rx_s=0.5)
    with shot_pool() as pool:
        found, _ = initial_fits(shots, JEWEL, pool)
        yield found[0], declared_fit(found, JEWEL, pool)


def test_the_amplitude_walks_as_a_frequency_makes_it(prepared):
    """d ln A / dt = d(t) sin(2 w t), summed for frequencies of an Ornstein-Uhlenbeck process."""
    shot, _ = prepared
    w, dt, count, draws = shot.state.dynamics.w, 2e-5, 20_000, 300
    stays = math.exp(-dt / PROCESS.tau_s)
    rng = np.random.default_rng(5)
    changes = rng.normal(size=(draws, count)) * 2.0 * math.pi * PROCESS.size * math.sqrt(1.0 - stays**2)
    frequency = lfilter([1.0], [1.0, -stays], changes, axis=1)
    grown = np.sum(frequency * np.sin(2.0 * w * dt * np.arange(count)), axis=1) * dt
    expected = FREQUENCY.pumped_per_s(PROCESS, [shot.state]) / THRESHOLDS.fluctuation.pumped_times
    assert grown.var() / (dt * count) == pytest.approx(expected, rel=0.3)
    assert FRICTION.pumped_per_s(PROCESS, [shot.state]) == 0.0


def with_course(shot, pumped_per_s):
    times = np.linspace(0.0, float(shot.time_s[-1]), KNOTS)
    root = PROCESS.root(times, FREQUENCY.unit([shot.state]))
    values = root @ np.random.default_rng(2).normal(size=KNOTS)
    nothing = TorqueCourse.none_of(JEWEL, float(times[1]), root, FREQUENCY.law)
    course = replace(nothing, values=values, pumped_per_s=pumped_per_s)
    return CourseState(shot.state.dynamics, shot.state.observation, shot.state.offsets, course)


def test_its_variance_grows_with_time(prepared):
    shot, _ = prepared
    windows, root = with_course(shot, 4e-6).course.pumped_amplitude(shot.time_s)
    variance = np.sum((windows.T @ root) ** 2, axis=1)
    assert variance[0] == 0.0
    assert variance[-1] == pytest.approx(4e-6 * shot.time_s[-1], rel=1e-6)
    nothing, _ = with_course(shot, 0.0).course.pumped_amplitude(shot.time_s)
    assert nothing.shape == (0, shot.time_s.size)


def test_it_counts_as_noise_of_the_losses_and_leaves_a_step_its_knots(prepared):
    shot, base = prepared
    quiet, pumped = (linearise_shot(shot, base.hypothesis, with_course(shot, d), base.strengths) for d in (0.0, 4e-6))
    place = 3  # of lambda
    assert pumped.own_covariance()[place, place] > 2.0 * quiet.own_covariance()[place, place]
    assert pumped.own_step(np.zeros(0)).size == quiet.own_step(np.zeros(0)).size == quiet.free.size + KNOTS


def test_a_frozen_course_leaves_torques_the_derivatives_they_have(prepared):
    shot, base = prepared
    state = with_course(shot, 0.0)
    torque = next(c for c in candidates_for(base) if c.effect.id == "quadratic_drag")
    wide = base.hypothesis.plus(torque)
    full = wide.extended(state, np.zeros(1))
    free, frozen = (linearise_signal(shot, wide.augmented, full, frozen_course=f) for f in (False, True))
    place = wide.strength_places()[0]
    assert frozen.signal == pytest.approx(free.signal, abs=1e-12 * np.abs(free.signal).max())
    assert frozen.jacobian[place] == pytest.approx(free.jacobian[place], abs=1e-6 * np.abs(free.jacobian[place]).max())
    assert free.jacobian.shape[0] == frozen.jacobian.shape[0] + 3 + KNOTS


def test_noise_between_widened_lines_is_flat_and_that_of_blank_shots_as_measured(prepared):
    shot, _ = prepared
    noise = estimate_noise(shot.shot.record)
    assert not noise.blank
    assert estimate_noise(shot.shot.record, blank=True).blank
    low = noise.frequency_hz < 600.0
    skirts = replace(noise, psd=np.where(low, 5.0 * noise.psd, noise.psd))
    with shot_pool() as pool:
        (widened,), _ = initial_fits([replace(shot.shot, noise=skirts)], JEWEL, pool)
        (blank,), _ = initial_fits([replace(shot.shot, noise=replace(skirts, blank=True))], JEWEL, pool)
    (flat,) = with_flat_noise([widened])
    assert flat.white.filters == (None,) * len(flat.grids)
    assert flat.shot.noise.sd == pytest.approx(noise.sd, rel=0.03)
    assert flat.shot.noise.degrees is not None  # it was measured
    assert with_flat_noise([blank]) is None
    assert with_flat_noise([flat]) is None

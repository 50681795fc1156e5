"""Errors of the parameters where the declared model leaves more than noise."""

import math
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.parameters import (
    Mean,
    WindowDifference,
    means,
    with_scales,
    with_what_is_left,
)
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, swing


@pytest.fixture(scope="module")
def fitted():
    """A plain pendulum's fit to a swing with dry friction."""
    angle = swing(0.8, 12.0, dry=0.004)
    read = angle + np.random.default_rng(1).normal(0.0, 1e-4, angle.size)
    record = RingDownRecord(read[None], RATE, "angle")
    pool = InlineExecutor()
    prepared, _ = initial_fits([DiagnosisShot("swing", record, estimate_noise(record))], THREAD, pool)
    return fit_jointly(prepared, Hypothesis(THREAD), pool)


def test_what_is_left_beside_a_model_widens_the_errors_of_its_parameters(fitted):
    base = fitted
    assert base.chi2_per_dof > 100.0
    of_noise_hz = math.sqrt(base.linear[0].own_covariance()[1, 1]) / (2.0 * math.pi)
    f_nat = means(base)["f_nat_hz"]
    assert f_nat.std == pytest.approx(math.sqrt(base.noise_factor) * of_noise_hz, rel=0.01)
    assert abs(f_nat.value - NATURAL_HZ) < 5.0 * f_nat.std


def test_errors_of_scales_add_to_the_parameters_own_in_quadrature():
    found = {
        "f_nat_hz": Mean(value=215.0, std=3e-5, scatter=None),
        "psi_start_rad": Mean(value=0.1, std=0.2, scatter=0),
    }
    settles = {"f_nat_hz": Mean(value=215.0 + 4e-5, std=1.0, scatter=None), "psi_start_rad": found["psi_start_rad"]}
    slides = {"psi_start_rad": Mean(value=2.0 * math.pi + 0.4, std=1.0, scatter=None)}  # moved by half an error
    wide = with_scales(found, [(settles, 1.0), (slides, 2.0)])
    assert wide["f_nat_hz"].value == 215.0
    assert wide["f_nat_hz"].std == pytest.approx(5e-5, rel=1e-6)
    assert wide["psi_start_rad"].std == pytest.approx(math.hypot(0.2, 0.6))


def test_what_is_not_explained_widens_the_errors_of_constants_alone(fitted):
    found = means(fitted)
    scattered = {n: replace(m, std=1e-9, scatter=2e-3) for n, m in found.items()}
    apart = {
        "f_nat_hz": WindowDifference(value=-0.5, std=0.01),
        "lambda_per_s": WindowDifference(value=0.5, std=0.4),
        "phi_max_rad": WindowDifference(value=0.5, std=0.01),
    }
    wider, told = with_what_is_left(scattered, fitted, apart)
    by_scatter = 2e-3 / math.sqrt(len(fitted.prepared))
    assert wider["f_nat_hz"].std == pytest.approx(math.hypot(by_scatter, 0.5))
    assert wider["lambda_per_s"].std == pytest.approx(by_scatter)  # 1.25 of its errors are chance
    assert wider["phi_max_rad"].std == 1e-9
    assert {n: m.value for n, m in wider.items()} == {n: m.value for n, m in found.items()}
    assert len(told) == 2
    assert "errors of f_nat_hz, lambda_per_s contain the scatter" in told[0]
    assert "errors of f_nat_hz contain the difference of N50 and D30" in told[1]
    alone = {n: replace(m, scatter=None) for n, m in scattered.items()}
    assert with_what_is_left(alone, fitted, {}) == (alone, [])


def test_a_difference_that_is_the_same_in_all_shots_is_beyond_chance():
    assert WindowDifference(value=0.1, std=0.0).sigma == math.inf


def test_the_scatter_of_few_shots_says_less_than_so_many_of_its_errors():
    noisy = [WindowDifference.of_shots(d, np.ones(4)) for d in np.random.default_rng(5).normal(size=(20000, 4))]
    beyond = np.mean([one.sigma > 1.96 for one in noisy])
    assert beyond == pytest.approx(0.05, abs=0.006)
    assert np.mean([abs(one.value) / one.std > 1.96 for one in noisy]) > 0.1


def test_of_few_shots_the_error_of_their_difference_is_that_of_their_noise():
    two = WindowDifference.of_shots(np.array([1.0, 1.2]), np.array([0.02, 0.02]))
    assert two.std == pytest.approx(0.1)
    assert two.sigma == pytest.approx(11.0)


def test_a_difference_far_beyond_its_scatter_stays_finite():
    assert 30.0 < WindowDifference(value=1e9, std=1.0, dof=99).sigma < 1e9

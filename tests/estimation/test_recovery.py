"""Random truths: any orientation and phase, from start values that the data alone provide."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, joint_chi2, random_truth, with_noise

JEWEL = Truth(f_nat_hz=213.05, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9176, psi_start_rad=3.8633)
THREAD = Truth()


def record_of(signal):
    return RingDownRecord(signal, RATE_HZ, "dmdt")


def surprises(variant, seeds, window, seconds, noise, f_range, deg_range):
    """Tail probabilities of the joint chi^2, and all pulls."""
    tails, pulls = [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        truth = random_truth(rng, variant, f_range, deg_range)
        signal = with_noise(dmdt(truth, seconds), rng, noise * NOISE_SD)
        result = fit_ring_down(record_of(signal), variant, window)
        if result.reason is not None and result.reason.startswith("amplitude_below_floor"):
            assert noise > 1.0, f"seed {seed}: {result.reason}, {truth}"
            continue
        assert result.verdict == "good", f"seed {seed}: {result.reason}, {truth}"
        tails.append(chi2.sf(joint_chi2(result, truth), len(result.covariance_names)))
        pulls.append(errors(result, truth) / np.sqrt(np.diag(result.covariance)))
    return np.array(tails), np.array(pulls)


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("noise", [1.0, 10.0])
def test_random_truths_are_recovered_within_their_errors(variant, noise):
    tails, pulls = surprises(variant, range(24), "n50", 0.3, noise, (100.0, 1000.0), (5.0, 75.0))
    assert np.count_nonzero(tails < 0.003) <= 1
    assert np.all(tails > 1e-6)
    assert np.mean(pulls**2) == pytest.approx(1.0, abs=0.3)


@pytest.mark.campaign
@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize(("window", "seconds"), [("n50", 0.3), ("d30", 1.5)])
@pytest.mark.parametrize("noise", [1.0, 10.0])
def test_many_random_truths_are_recovered_within_their_errors(variant, window, seconds, noise):
    tails, pulls = surprises(variant, range(100, 400), window, seconds, noise, (100.0, 1000.0), (5.0, 75.0))
    print(variant, window, noise, "sd of pulls", pulls.std(axis=0).round(3), "mean", pulls.mean(axis=0).round(3))
    assert np.count_nonzero(tails < 0.003) <= 5
    assert np.all(np.abs(pulls.std(axis=0) - 1.0) < 0.15)
    assert np.all(np.abs(pulls.mean(axis=0)) < 0.25)


@pytest.mark.parametrize(("variant", "truth"), [("thread", THREAD), ("jewel", JEWEL)])
def test_without_noise_the_truth_comes_back_to_many_digits(variant, truth):
    result = fit_ring_down(record_of(dmdt(truth, 0.3)), variant, "n50", noise=NoiseModel.white(NOISE_SD, RATE_HZ))
    pulls = errors(result, truth) / np.sqrt(np.diag(result.covariance))
    assert np.all(np.abs(pulls) < 1e-3), dict(zip(result.covariance_names, pulls, strict=True))
    assert result.r2 <= 1.0


@pytest.mark.parametrize(("variant", "truth"), [("thread", THREAD.with_(phi_max_rad=0.6)), ("jewel", JEWEL)])
def test_a_record_without_noise_leaves_rounding_and_nothing_is_read_into_that(variant, truth):
    tiny = NoiseModel.white(np.full(3, 1e-9), RATE_HZ)
    result = fit_ring_down(record_of(dmdt(truth, 0.3)), variant, "n50", noise=tiny)
    assert result.nrmse < 1e-9
    assert not result.notes


@pytest.mark.parametrize("psi_deg", [0.0, 1e-6, 90.0, 179.999, 180.0, 180.001, 270.0, 359.999])
@pytest.mark.parametrize(("variant", "truth"), [("thread", THREAD), ("jewel", JEWEL)])
def test_a_start_at_a_turning_point_is_as_good_as_any_other(variant, truth, psi_deg):
    truth = truth.with_(psi_start_rad=math.radians(psi_deg))
    rng = np.random.default_rng(5)
    result = fit_ring_down(record_of(with_noise(dmdt(truth, 0.25), rng)), variant, "n50")
    assert result.verdict == "good", result.reason
    assert 0.0 <= result.parameters["psi_start_rad"].value < 2 * math.pi
    assert chi2.sf(joint_chi2(result, truth), len(result.covariance_names)) > 1e-4


def test_the_half_turn_ambiguity_is_resolved_towards_positive_x():
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_rotvec(JEWEL.rodrigues).as_matrix() @ np.diag([1.0, -1.0, -1.0])
    flipped = JEWEL.with_(
        rodrigues=tuple(Rotation.from_matrix(turned).as_rotvec()),
        psi_start_rad=(JEWEL.psi_start_rad + math.pi) % (2 * math.pi),
    )
    assert np.allclose(dmdt(flipped, 0.3), dmdt(JEWEL, 0.3), atol=1e-9)
    result = fit_ring_down(record_of(with_noise(dmdt(flipped, 0.3), np.random.default_rng(3))), "jewel", "n50")
    assert chi2.sf(joint_chi2(result, JEWEL), 9) > 1e-4


def test_the_fit_does_not_care_where_the_ring_down_begins_in_its_decay():
    whole = dmdt(JEWEL, 0.8)
    cut = whole[:, 20000:]
    result = fit_ring_down(record_of(with_noise(cut, np.random.default_rng(4))), "jewel", "n50")
    friction = result.parameters["tf_over_i_rad_per_s2"]
    assert abs(friction.value - 1190.0) < 4 * friction.std
    assert result.parameters["phi_max_rad"].value < 0.75


def test_a_fixed_lambda_is_reported_without_error_and_sharpens_the_friction():
    signal = with_noise(dmdt(JEWEL, 0.25), np.random.default_rng(6))
    free = fit_ring_down(record_of(signal), "jewel", "n50")
    fixed = fit_ring_down(record_of(signal), "jewel", "n50", fixed={"lambda_per_s": 0.2465})
    assert fixed.parameters["lambda_per_s"].value == 0.2465
    assert fixed.parameters["lambda_per_s"].std is None
    assert "lambda_per_s" not in fixed.covariance_names
    assert fixed.covariance.shape == (8, 8)
    name = "tf_over_i_rad_per_s2"
    assert fixed.parameters[name].std < 0.2 * free.parameters[name].std
    assert chi2.sf(joint_chi2(fixed, JEWEL), 8) > 1e-4


def test_frequency_and_moment_can_be_fixed_too():
    signal = with_noise(dmdt(THREAD, 0.25), np.random.default_rng(7))
    fixed = {"f_nat_hz": THREAD.f_nat_hz, "m_r_am2": THREAD.m_r_am2}
    result = fit_ring_down(record_of(signal), "thread", "n50", fixed=fixed)
    assert {n for n, e in result.parameters.items() if e.std is None} == set(fixed)
    assert chi2.sf(joint_chi2(result, THREAD), 6) > 1e-4


def test_an_offset_of_a_channel_moves_no_parameter():
    signal = with_noise(dmdt(THREAD, 0.25), np.random.default_rng(8))
    plain = fit_ring_down(record_of(signal), "thread", "n50")
    shifted = fit_ring_down(record_of(signal + np.array([[2.0], [-1.0], [5.0]])), "thread", "n50")
    for name, estimate in plain.parameters.items():
        assert shifted.parameters[name].value == pytest.approx(estimate.value, abs=0.02 * estimate.std)


def test_a_thread_has_no_friction_parameter_and_a_jewel_model_finds_none_in_it():
    signal = with_noise(dmdt(THREAD, 1.0), np.random.default_rng(9))
    assert "tf_over_i_rad_per_s2" not in fit_ring_down(record_of(signal), "thread").parameters
    friction = fit_ring_down(record_of(signal), "jewel").parameters["tf_over_i_rad_per_s2"]
    assert abs(friction.value) < 4 * friction.std


def test_samples_outside_the_valid_range_are_not_looked_at():
    signal = with_noise(dmdt(THREAD, 0.5), np.random.default_rng(10))
    signal[:, :200] = 1e6
    signal[:, -200:] = np.nan
    record = RingDownRecord(signal, RATE_HZ, "dmdt", valid_from=200, valid_to=signal.shape[1] - 200)
    result = fit_ring_down(record, "thread")
    assert result.samples == signal.shape[1] - 400
    assert chi2.sf(joint_chi2(result, THREAD), 8) > 1e-4


def test_sticking_inside_the_window_does_not_disturb_the_fit():
    truth = JEWEL.with_(tf_over_i_rad_per_s2=9000.0, phi_max_rad=0.4)
    signal = with_noise(dmdt(truth, 0.4), np.random.default_rng(11))
    assert np.all(dmdt(truth, 0.4)[:, -2000:] == 0.0)
    result = fit_ring_down(record_of(signal), "jewel", 0.4)
    assert result.verdict == "good", result.reason
    assert chi2.sf(joint_chi2(result, truth), 9) > 1e-4


@pytest.mark.parametrize("per_period", [4.05, 4.22, 4.4, 4.5, 4.91, 5.5, 5.91, 7.0])
@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_four_samples_a_period_are_enough_where_harmonics_fold_onto_each_other_too(variant, per_period):
    every = 60
    rng = np.random.default_rng(round(100.0 * per_period))
    truth = random_truth(rng, variant, (RATE_HZ / every / per_period,) * 2, (30.0, 70.0))
    rate = truth.f_nat_hz * per_period
    signal = with_noise(dmdt(truth, 0.5)[:, :: round(RATE_HZ / rate)], rng)
    record = RingDownRecord(signal, RATE_HZ / round(RATE_HZ / rate), "dmdt")
    given = fit_ring_down(record, variant, 0.24, noise=NoiseModel.white(NOISE_SD, record.sampling_rate_hz))
    assert given.verdict == "good", given.reason
    assert chi2.sf(joint_chi2(given, truth), len(given.covariance_names)) > 1e-4
    own = fit_ring_down(record, variant, 0.24)
    assert own.verdict == "good", own.reason
    assert 0.3 < own.chi2_per_dof < 1.3  # half of the band may be harmonics: then errors are a little too large

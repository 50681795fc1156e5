"""Angle records that the model does not follow: the misfit is no noise, and is named."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.goodness_of_fit.noise_floor import noise_floor_of
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, swing


def fitted(angle, variant="thread", noise=1e-3, seed=0):
    noisy = angle + np.random.default_rng(seed).normal(0, noise, angle.size)
    return fit_ring_down(RingDownRecord(noisy[None], RATE, "angle"), variant, 1e9)


def codes(result):
    return {warning.partition(":")[0] for warning in result.warnings}


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 5e-3])
@pytest.mark.parametrize(("amplitude", "periods"), [(2.2, 6.7), (1.0, 8.0), (0.7, 11.0)])
def test_dry_friction_in_few_periods_is_no_noise_of_a_thread(amplitude, periods, noise):
    angle = swing(amplitude, periods, viscous=0.013, dry=0.03 * amplitude / periods)
    plain = fitted(swing(amplitude, periods, viscous=0.013), noise=noise)
    thread, dry = fitted(angle, noise=noise), fitted(angle, "jewel_constant_friction", noise)
    assert dry.verdict == "good"
    assert codes(dry) <= {"window_too_short"}
    if thread.verdict == "refused":
        assert "jewel_constant_friction reaches" in thread.reason
        return
    assert {"residual_not_white", "other_variant"} <= codes(thread)
    assert thread.parameters["lambda_per_s"].std > 1.5 * plain.parameters["lambda_per_s"].std
    assert "errors made" in next(w for w in thread.warnings if w.startswith("residual_not_white"))


def test_a_thread_whose_damping_is_mostly_friction_is_refused():
    result = fitted(swing(0.8, 9.0, viscous=0.001, dry=0.01))
    assert result.verdict == "refused"
    assert "jewel_constant_friction reaches" in result.reason


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("periods", [6.5, 12.0, 40.0])
def test_noise_of_any_smooth_colour_and_steps_of_an_encoder_are_noise(periods, seed):
    rng = np.random.default_rng(seed)
    angle, viscous = swing(rng.uniform(0.2, 1.8), periods), 0.004 * 2 * math.pi * NATURAL_HZ
    a = 1 - math.exp(-2 * math.pi * NATURAL_HZ * rng.uniform(8, 40) / RATE)
    slow = lfilter([a], [1, a - 1], rng.normal(0, 5e-3, angle.size + 200))[200:]
    step = np.ptp(angle) / rng.uniform(100, 3000)
    for read in (angle + slow, np.round(angle / step) * step):
        result = fitted(read, noise=1e-9, seed=seed)
        assert result.verdict == "good", result.reason
        assert codes(result) <= {"window_too_short", "loss_not_seen"}
        for name, truth in (("f_nat_hz", NATURAL_HZ), ("lambda_per_s", viscous)):
            estimate = result.parameters[name]
            assert abs(estimate.value - truth) < 4.5 * estimate.std


@pytest.mark.parametrize("other_hz", [1.1, 2.7, 3.4])
def test_two_pendulums_in_one_angle_are_refused(other_hz):
    angle = swing(1.2, 40)
    time_s = np.arange(angle.size) / RATE
    second = 0.25 * np.exp(-0.05 * time_s) * np.cos(2 * math.pi * other_hz * time_s)
    result = fitted(angle + second)
    assert result.verdict == "refused"
    assert result.reason.startswith(("two_resonators", "model_does_not_explain"))


def test_a_drift_of_the_zero_is_fitted_too_and_noted():
    angle = swing(1.2, 40)
    result = fitted(angle + 0.1 * np.linspace(0, 1, angle.size) ** 2)
    assert any("drift fitted too" in note for note in result.notes)
    assert result.chi2_per_dof == pytest.approx(1.0, abs=0.3)
    f = result.parameters["f_nat_hz"]
    assert abs(f.value - NATURAL_HZ) < 5 * f.std


def test_a_misfit_of_few_periods_is_not_taken_for_a_drift():
    result = fitted(swing(2.2, 6.7, dry=0.02))
    assert not any("drift" in note for note in result.notes)


def test_the_floor_is_the_noise_for_any_misfit_at_the_harmonics():
    rng = np.random.default_rng(0)
    noise, time_s = rng.normal(0, 0.01, 4000), np.arange(4000) / RATE
    alone = noise_floor_of(noise, RATE, NATURAL_HZ)
    below = noise_floor_of(noise + 0.1 * np.cos(2 * math.pi * NATURAL_HZ * time_s), RATE, NATURAL_HZ)
    assert alone.sd(RATE) == pytest.approx(0.01, rel=0.2)
    assert below.sd(RATE) == pytest.approx(0.01, rel=0.2)
    assert not alone.sure
    assert alone.widening(0.01, RATE) == 1.0
    assert below.sure
    assert below.widening(0.01, RATE) > 100.0


def test_too_few_bins_show_no_floor():
    assert noise_floor_of(np.random.default_rng(0).normal(size=200), 20.0, 5.0) is None


@pytest.mark.parametrize(("amplitude", "periods"), [(1.2, 40.0), (2.2, 8.0), (0.3, 20.0)])
def test_the_digits_of_a_record_without_noise_are_no_misfit(amplitude, periods):
    fit = fitted(swing(amplitude, periods))
    exact = fit.model_signal(4000, RATE)[0]
    assert codes(fitted(exact, noise=1e-17)) <= {"window_too_short"}

"""Peaks over rms, and the D30 window that ends where the peaks have decayed."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.cramer_rao import MeasurementPlan, planned_window_s
from platform_daemon.estimation.physics.orbit import frequency_ratio
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.crest import crest_factor
from platform_daemon.estimation.screening.windows import select_window
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, random_truth, with_noise


def strongest(signal):
    return int(np.argmax(np.sum(signal[:, : signal.shape[1] // 4] ** 2, axis=1)))


@pytest.mark.parametrize("seed", range(12))
def test_the_crest_factor_is_that_of_the_waveform_in_noise_and_with_a_frequency_that_is_a_little_wrong(seed):
    rng = np.random.default_rng(seed)
    truth = random_truth(rng, "thread", deg_range=(10, 70)).with_(lambda_per_s=1e-6)
    f = frequency_ratio(truth.phi_max_rad) * truth.f_nat_hz
    signal = dmdt(truth, 20 / f)
    channel = strongest(signal)
    y = signal[channel, : round(12 / f * RATE_HZ)]
    true = np.abs(y).max() / math.sqrt(np.mean(y**2))
    noisy = with_noise(signal, rng)[channel]
    for wrong in (0.96, 1.0, 1.04):
        assert crest_factor(noisy, centre=y.size // 2, rate_hz=RATE_HZ, frequency_hz=wrong * f) == pytest.approx(
            true, rel=0.012
        )


def test_the_crest_factor_of_a_sine_is_the_root_of_two_at_any_level_and_offset():
    y = 3.0 + 1e-3 * np.sin(2 * math.pi * 210 * np.arange(5000) / RATE_HZ)
    assert crest_factor(y, centre=2000, rate_hz=RATE_HZ, frequency_hz=205.0) == pytest.approx(math.sqrt(2), rel=2e-3)


@pytest.mark.parametrize(("samples", "frequency_hz"), [(500, 210.0), (20000, RATE_HZ / 4.5)])
def test_too_few_periods_or_samples_have_no_crest_factor(samples, frequency_hz):
    y = np.sin(2 * math.pi * frequency_hz * np.arange(samples) / RATE_HZ)
    assert crest_factor(y, centre=samples // 2, rate_hz=RATE_HZ, frequency_hz=frequency_hz) is None


def peaks_decayed_s(signal, f):
    """When the largest values of periods have fallen to 30 %, by the noise-free samples."""
    period = int(RATE_HZ / f)
    blocks = np.abs(signal[: signal.size // period * period]).reshape(-1, period).max(axis=1)
    return (np.flatnonzero(blocks < 0.3 * blocks.max())[0] + 0.5) * period / RATE_HZ


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_d30_ends_where_the_peaks_of_the_strongest_channel_have_30_percent_left(variant, scale):
    misses = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth = random_truth(rng, variant, f_range=(150.0, 350.0), deg_range=(40, 65))
        w = 2 * math.pi * truth.f_nat_hz
        truth = truth.with_(lambda_per_s=w / 1200, tf_over_i_rad_per_s2=w * w * 1.5e-3 if variant == "jewel" else 0.0)
        f = frequency_ratio(truth.phi_max_rad) * truth.f_nat_hz
        signal = dmdt(truth, 2.0 / truth.lambda_per_s)
        record = RingDownRecord(with_noise(signal, rng, scale * NOISE_SD), RATE_HZ, "dmdt")
        taken = select_window(record, "d30", f, scale * NOISE_SD).last / RATE_HZ
        misses.append(taken / peaks_decayed_s(signal[strongest(signal)], f) - 1.0)
    assert np.abs(misses).max() < 0.035
    assert abs(np.mean(misses)) < 0.02


def test_a_planned_d30_is_the_one_that_a_fit_will_take():
    truth = Truth(f_nat_hz=213.25, tf_over_i_rad_per_s2=1324.0, phi_max_rad=0.925, psi_start_rad=3.83)
    names = ["f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2", "phi_max_rad", "psi_start_rad"]
    values = {name: truth.value(name) for name in (*names, *(f"rodrigues_{a}" for a in "xyz"))}
    planned = planned_window_s(MeasurementPlan("jewel", values, NOISE_SD, RATE_HZ), "d30")
    record = RingDownRecord(with_noise(dmdt(truth, 1.5), np.random.default_rng(1)), RATE_HZ, "dmdt")
    taken = select_window(record, "d30", frequency_ratio(truth.phi_max_rad) * truth.f_nat_hz, NOISE_SD)
    assert taken.last / RATE_HZ == pytest.approx(planned, rel=0.015)

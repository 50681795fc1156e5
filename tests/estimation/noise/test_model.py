"""Noise is measured between the harmonics of the signal."""

import numpy as np
import pytest
from scipy.signal import lfilter

from platform_daemon.estimation.noise.model import NoiseModel, estimate_noise, level_sd
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, with_noise

JEWEL = Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=1.2, psi_start_rad=3.86)


def noise_of(signal, quantity="dmdt"):
    return estimate_noise(RingDownRecord(signal, RATE_HZ, quantity))


@pytest.mark.parametrize("truth", [Truth(), JEWEL, JEWEL.with_(f_nat_hz=700.0), Truth(f_nat_hz=110.0)])
@pytest.mark.parametrize("scale", [1.0, 10.0])
def test_the_noise_under_a_ring_down_is_found_within_two_percent(truth, scale):
    signal = with_noise(dmdt(truth, 1.0), np.random.default_rng(0), scale * NOISE_SD)
    assert np.allclose(noise_of(signal).sd, scale * NOISE_SD, rtol=0.02)


def test_a_weak_channel_is_not_contaminated_by_a_strong_one():
    signal = with_noise(dmdt(JEWEL, 1.0), np.random.default_rng(1), [1e-4, 0.02, 1e-3])
    assert np.allclose(noise_of(signal).sd, [1e-4, 0.02, 1e-3], rtol=0.03)


def test_noise_without_any_signal_is_its_standard_deviation():
    signal = with_noise(np.zeros((3, 40000)), np.random.default_rng(2))
    assert np.allclose(noise_of(signal).sd, NOISE_SD, rtol=0.02)


def test_an_offset_is_not_noise():
    signal = with_noise(dmdt(Truth(), 0.5), np.random.default_rng(3)) + 7.0
    assert np.allclose(noise_of(signal).sd, NOISE_SD, rtol=0.03)


def test_the_spectrum_integrates_to_the_variance_and_shows_colour():
    rng = np.random.default_rng(4)
    coloured = lfilter([1.0], [1.0, -0.9], rng.standard_normal(60000))
    signal = dmdt(Truth(), 60000 / RATE_HZ) + 0.02 * coloured
    noise = noise_of(signal)
    step = noise.frequency_hz[1]
    assert np.allclose(noise.psd.sum(axis=1) * step, noise.sd**2)
    assert noise.sd[0] == pytest.approx(0.02 * coloured.std(), rel=0.05)
    low, high = np.interp([1500.0, 25000.0], noise.frequency_hz, np.mean(noise.psd, axis=0))
    assert low > 30 * high


def test_a_slowly_sampled_record_has_its_folded_harmonics_masked():
    signal = with_noise(dmdt(JEWEL.with_(tf_over_i_rad_per_s2=0.0), 2.0), np.random.default_rng(5))[:, ::30]
    noise = estimate_noise(RingDownRecord(signal, RATE_HZ / 30, "dmdt"))
    assert np.allclose(noise.sd, NOISE_SD, rtol=0.12)


@pytest.mark.parametrize("per_period", [4.1, 4.3, 5.5, 8.0])
def test_folded_harmonics_that_fill_the_band_are_hardly_taken_for_noise(per_period):
    truth = JEWEL.with_(f_nat_hz=RATE_HZ / 40 / per_period, tf_over_i_rad_per_s2=0.0)
    signal = with_noise(dmdt(truth, 0.24), np.random.default_rng(6))[:, ::40]
    ratio = estimate_noise(RingDownRecord(signal, RATE_HZ / 40, "dmdt")).sd / NOISE_SD
    assert np.all((ratio > 0.8) & (ratio < 2.0)), ratio


@pytest.mark.parametrize("hum_hz", [97.0, 100.0, 103.0])
def test_hum_at_half_the_frequency_is_not_taken_for_the_fundamental(hum_hz):
    clean = dmdt(Truth(f_nat_hz=206.0, phi_max_rad=0.5), 0.5)
    hum = 0.15 * np.sin(2.0 * np.pi * hum_hz * np.arange(clean.shape[1]) / RATE_HZ)
    noise = noise_of(with_noise(clean + hum, np.random.default_rng(7)))
    assert np.allclose(noise.without_tones(np.array([hum_hz])).sd, NOISE_SD, rtol=0.03)


def test_white_noise_of_known_size_integrates_to_its_variance():
    noise = NoiseModel.white(NOISE_SD, RATE_HZ)
    assert np.allclose(np.trapezoid(noise.psd, noise.frequency_hz, axis=1), NOISE_SD**2)


@pytest.mark.long
@pytest.mark.parametrize(("frequency_hz", "periods"), [(600.0, 6.2), (215.0, 8.0), (215.0, 60.0)])
def test_the_noise_model_knows_the_uncertainty_of_its_level(frequency_hz, periods):
    rng, truth = np.random.default_rng(7), Truth(f_nat_hz=frequency_hz)
    clean = dmdt(truth, periods / frequency_hz)
    models = [noise_of(with_noise(clean, rng)) for _ in range(40)]
    scatter = np.std([np.log(m.sd**2 / NOISE_SD**2) for m in models])
    assert 0.7 * scatter < np.mean([level_sd(m) for m in models]) < 1.5 * scatter


def test_the_level_of_given_noise_is_known():
    assert level_sd(NoiseModel.white(NOISE_SD, RATE_HZ)) == 0.0

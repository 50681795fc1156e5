"""Noise that is not white: its level at the harmonics, the weights and errors that follow from it."""

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.noise.model import NoiseModel, estimate_noise
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.coloured_noise import band, one_pole, pink, three, white
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, with_noise

JEWEL = Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.93, psi_start_rad=3.86)
HARMONICS = np.array([212.0, 424.0])
COLOURS = {"pink": pink(300.0), "red": pink(1000.0, 1.5), "one_pole": one_pole(1000.0), "band": band(100.0, 700.0)}


def levels(make, truth, seconds, draws):
    """(draws, 2): level at f and 2f found in one channel, others white."""
    clean = dmdt(truth, seconds)
    n = clean.shape[1]
    found = []
    for seed in range(draws):
        rng = np.random.default_rng(seed)
        noise = estimate_noise(RingDownRecord(clean + three(make, NOISE_SD, rng, n), RATE_HZ, "dmdt"))
        found.append(sd_at(noise, HARMONICS, RATE_HZ) / NOISE_SD[:, None])
    return np.concatenate(found)


@pytest.mark.parametrize("name", COLOURS)
@pytest.mark.parametrize("truth", [Truth(), JEWEL])
def test_the_level_at_the_harmonics_is_found_under_the_signal(name, truth):
    make, density = COLOURS[name]
    relative = levels(make, truth, 1.0, 8) / np.sqrt(density(HARMONICS))
    # A law that is smooth over octaves follows no edges.
    room = 0.25 if name == "band" else 0.12
    assert np.mean(relative, axis=0) == pytest.approx(1.0, abs=room)
    assert np.all(np.std(relative, axis=0) < room)


def test_white_noise_is_taken_for_white_and_its_level_is_that_of_all_frequencies():
    found = levels(white, Truth(), 0.24, 40)
    broad = np.abs(found - 1.0)
    assert np.mean(broad < 0.03) > 0.98
    assert np.all(broad < 0.4)


def test_a_spectrum_known_exactly_is_taken_at_its_word():
    grid = np.array([0.0, 300.0, 30000.0])
    density = np.array([[4.0, 1.0, 1.0]]) * 2.0 / RATE_HZ
    noise = NoiseModel(sd=np.array([1.0]), frequency_hz=grid, psd=density)
    assert sd_at(noise, np.array([150.0, 1000.0]), RATE_HZ) == pytest.approx(np.sqrt([[2.5, 1.0]]))


def pulls(make, truth, variant, seconds, draws, coloured=(0, 1, 2)):
    """(draws, k) errors over predicted standard deviations."""
    clean = dmdt(truth, seconds)
    n = clean.shape[1]
    out = []
    for seed in range(draws):
        rng = np.random.default_rng(seed)
        noise = np.stack([(make if c in coloured else white)(rng, n) * NOISE_SD[c] for c in range(3)])
        result = fit_ring_down(RingDownRecord(clean + noise, RATE_HZ, "dmdt"), variant, seconds)
        assert result.verdict == "good", result.reason
        assert result.chi2_per_dof == pytest.approx(1.0, abs=0.25)
        out.append(errors(result, truth) / np.sqrt(np.diag(result.covariance)))
    return np.array(out)


@pytest.mark.campaign
@pytest.mark.parametrize("name", ["pink", "one_pole"])
@pytest.mark.parametrize(
    ("variant", "truth", "seconds"),
    [("thread", Truth(), 0.5), pytest.param("jewel", JEWEL, 0.5, marks=pytest.mark.campaign)],
)
def test_scatter_in_coloured_noise_is_the_predicted_one(name, variant, truth, seconds):
    draws = 150
    found = pulls(COLOURS[name][0], truth, variant, seconds, draws)
    assert np.all(np.abs(found.mean(axis=0)) < 4.0 / np.sqrt(draws))
    assert np.all(np.abs(found.std(axis=0) - 1.0) < 0.3)
    assert np.sqrt(np.mean(found**2)) == pytest.approx(1.0, abs=0.12)


def test_a_band_of_noise_on_z_only_is_weighted_down_without_bias():
    draws = 100
    found = pulls(COLOURS["band"][0], Truth(), "thread", 0.5, draws, coloured=(2,))
    assert np.all(np.abs(found.mean(axis=0)) < 4.0 / np.sqrt(draws))
    assert np.sqrt(np.mean(found**2)) == pytest.approx(1.0, abs=0.12)


@pytest.mark.long
def test_weighting_by_harmonic_scatters_less_than_one_weight_per_channel_where_only_2f_is_noisy():
    clean = dmdt(JEWEL, 0.5)
    make, density = band(380.0, 480.0, height=400.0)
    grid = np.linspace(0.0, RATE_HZ / 2, 4000)
    broad = np.sqrt(np.mean(density(grid[1:])))
    known = NoiseModel(
        sd=broad * NOISE_SD, frequency_hz=grid, psd=np.outer(2 * NOISE_SD**2 / RATE_HZ, density(np.maximum(grid, 1.0)))
    )
    plain = NoiseModel.white(broad * NOISE_SD, RATE_HZ)
    misses = {"known": [], "plain": []}
    for seed in range(60):
        signal = clean + three(make, NOISE_SD, np.random.default_rng(seed), clean.shape[1])
        for name, noise in (("known", known), ("plain", plain)):
            result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "jewel", 0.5, noise=noise)
            misses[name].append(errors(result, JEWEL))
    ratio = np.std(misses["known"], axis=0) / np.std(misses["plain"], axis=0)
    assert np.exp(np.mean(np.log(ratio))) < 0.9


def test_noise_that_is_known_to_be_white_changes_nothing():
    signal = with_noise(dmdt(Truth(), 0.24), np.random.default_rng(0))
    record = RingDownRecord(signal, RATE_HZ, "dmdt")
    flat = NoiseModel.white(NOISE_SD, RATE_HZ)
    measured = NoiseModel(
        sd=flat.sd, frequency_hz=np.linspace(0, RATE_HZ / 2, 2001), psd=np.repeat(flat.psd[:, :1], 2001, axis=1)
    )
    one, other = (fit_ring_down(record, "thread", noise=n) for n in (flat, measured))
    assert {n: e.value for n, e in one.parameters.items()} == {n: e.value for n, e in other.parameters.items()}
    assert np.array_equal(one.covariance, other.covariance)

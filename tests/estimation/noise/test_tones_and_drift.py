"""Mains hum, other steady tones and drift: found where they are, nowhere else, and fitted together with the signal."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.tones_and_drift import drift_degree, find_tones
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.spectral_lines import Zones
from tests.kit.coloured_noise import pink, three
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, with_noise

JEWEL = Truth(f_nat_hz=213.25, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.93, psi_start_rad=3.86)
CASES = {"thread": (Truth(), 0.24), "jewel": (JEWEL, 0.24)}
BLOCK_RATE_HZ = 4300.0
SIDES = np.array([[1.0], [0.4], [0.2]])


def blocks(seed, n=1000):
    return np.random.default_rng(seed).standard_normal((3, n))


def seconds(n=1000):
    return np.arange(n) / BLOCK_RATE_HZ


def test_white_residuals_hold_no_tones_and_no_drift():
    assert sum(find_tones(blocks(k), BLOCK_RATE_HZ, None).size for k in range(1000)) == 0
    assert sum(drift_degree(blocks(k)) for k in range(1000)) == 0


def test_steady_tones_are_found_within_a_fraction_of_what_the_window_resolves():
    r = blocks(0) + SIDES * sum(np.sin(2 * np.pi * f * seconds() + f) for f in (50.0, 150.3, 700.0))
    assert np.sort(find_tones(r, BLOCK_RATE_HZ, None)) == pytest.approx([50.0, 150.3, 700.0], abs=0.5)


def test_what_decays_is_not_steady():
    line = np.exp(-seconds() / 0.2) * np.sin(2 * np.pi * 331.0 * seconds())
    assert find_tones(blocks(1) + 3.0 * SIDES * line, BLOCK_RATE_HZ, None).size == 0


@pytest.mark.parametrize("frequency_hz", [299.2, 720.0])
@pytest.mark.parametrize("rate_per_s", [0.3, 0.6])
def test_what_decays_like_a_resonator_is_no_mains_either(frequency_hz, rate_per_s):
    line = np.exp(-rate_per_s * seconds()) * np.sin(2 * np.pi * frequency_hz * seconds())
    assert find_tones(blocks(1) + 20.0 * SIDES * line, BLOCK_RATE_HZ, None).size == 0


@pytest.mark.parametrize("shape", [(0.0,), (-0.03,), (0.1,), (-0.09, 0.02, 0.03), (-0.05, -0.05, 0.04)])
def test_mains_that_wanders_is_still_mains(shape):
    """Its size, by coefficients of Legendre polynomials in time, may change, but hardly at the same rate throughout."""
    x = np.linspace(-1.0, 1.0, seconds().size)
    size = 1.0 + np.polynomial.legendre.legval(x, [0.0, *(0.5 * c for c in shape)])
    line = size * np.sin(2 * np.pi * 300.0 * seconds())
    assert find_tones(blocks(1) + 100.0 * SIDES * line, BLOCK_RATE_HZ, None) == pytest.approx([300.0], abs=0.1)


def test_what_changes_its_pitch_is_not_steady():
    t = seconds()
    line = np.sin(2 * np.pi * (331.0 * t + 10.0 * t**2))
    assert find_tones(blocks(1) + 3.0 * SIDES * line, BLOCK_RATE_HZ, None).size == 0


@pytest.mark.parametrize("frequency_hz", [201.0, 212.5, 412.0, 424.0, 630.0])
def test_nothing_is_taken_from_where_a_harmonic_sweeps(frequency_hz):
    zones = Zones(low_hz=200.0, high_hz=213.0, margin_hz=15.0)
    r = blocks(2) + 3.0 * SIDES * np.sin(2 * np.pi * frequency_hz * seconds())
    assert find_tones(r, BLOCK_RATE_HZ, zones).size == 0
    assert find_tones(r, BLOCK_RATE_HZ, None).size == 1


def test_drift_is_seen_with_the_degree_it_has():
    x = np.linspace(-1.0, 1.0, 1000)
    assert drift_degree(blocks(3) + 1.0 * SIDES * x) == 1
    assert drift_degree(blocks(3) + 1.0 * SIDES * x**3) == 3


def hum(n, rng, sizes=((50.0, 0.02), (150.0, 0.04), (250.0, 0.01))):
    t = np.arange(n) / RATE_HZ
    return sum(
        a * np.stack([s * np.sin(2 * math.pi * f * t + rng.uniform(0, 2 * math.pi)) for s in (1.0, 0.7, 2.5)])
        for f, a in sizes
    )


def drift(n, rng):
    x = np.linspace(0.0, 1.0, n)
    return np.stack([s * (rng.uniform(-0.2, 0.2) * x + rng.uniform(-0.2, 0.2) * x**2) for s in (1.0, 0.7, 2.5)])


DISTURBANCES = {"hum": hum, "drift": drift, "both": lambda n, rng: hum(n, rng) + drift(n, rng)}


def draw(variant, disturb, draws, make=None):
    """(draws, k) errors over predicted standard deviations, and the results."""
    truth, length = CASES[variant]
    clean = dmdt(truth, length)
    n = clean.shape[1]
    pulls, results = [], []
    for seed in range(draws):
        rng = np.random.default_rng(seed)
        signal = with_noise(clean, rng) if make is None else clean + three(make, NOISE_SD, rng, n)
        result = fit_ring_down(RingDownRecord(signal + disturb(n, rng), RATE_HZ, "dmdt"), variant, length)
        assert result.verdict == "good", result.reason
        pulls.append(errors(result, truth) / np.sqrt(np.diag(result.covariance)))
        results.append(result)
    return np.array(pulls), results


@pytest.mark.parametrize(
    ("name", "variant"),
    [
        pytest.param(d, v, marks=pytest.mark.long if (d, v) == ("both", "thread") else pytest.mark.campaign)
        for d in DISTURBANCES
        for v in CASES
    ],
)
def test_hum_and_drift_neither_bias_the_estimates_nor_their_errors(variant, name):
    draws = 60
    pulls, results = draw(variant, DISTURBANCES[name], draws)
    assert np.all(np.abs(pulls.mean(axis=0)) < 4.0 / math.sqrt(draws))
    assert np.all(np.abs(pulls.std(axis=0) - 1.0) < 0.4)
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(1.0, abs=0.15)
    assert np.mean([r.chi2_per_dof for r in results]) == pytest.approx(1.0, abs=0.03)


def test_notes_say_what_was_removed_with_its_frequency_and_size():
    _, (result,) = draw("thread", DISTURBANCES["both"], 1)
    tones = [n for n in result.notes if n.startswith("steady tone")]
    assert any("50." in n or "49." in n for n in tones)
    strongest = next(n for n in tones if "150." in n or "149." in n)
    first = float(strongest.split("amplitude ")[1].split(",")[0])
    assert first == pytest.approx(0.04, rel=0.1)
    assert any(n.startswith("drift") for n in result.notes)


@pytest.mark.parametrize("hum_hz", [49.9, 60.0])
def test_hum_of_five_periods_is_hum_and_no_drift(hum_hz):
    pulls = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        clean = dmdt(JEWEL, 0.3)
        wave = np.sin(2.0 * np.pi * (hum_hz * np.arange(clean.shape[1]) / RATE_HZ + rng.random()))
        record = RingDownRecord(with_noise(clean, rng) + 0.15 * SIDES * wave, RATE_HZ, "dmdt")
        result = fit_ring_down(record, "jewel", 0.1)
        assert any(note.startswith("steady tone") for note in result.notes), result.notes
        pulls.append(errors(result, JEWEL) / np.sqrt(np.diag(result.covariance)))
    assert np.sqrt(np.mean(np.square(pulls))) < 1.4


@pytest.mark.long
@pytest.mark.parametrize("variant", CASES)
def test_clean_records_have_nothing_removed(variant):
    _, results = draw(variant, lambda n, rng: 0.0, 200)
    assert not any("fitted too" in note for r in results for note in r.notes)


def test_a_model_that_lacks_an_effect_keeps_its_misfit():
    signal = with_noise(dmdt(JEWEL, 0.5), np.random.default_rng(0), 0.1 * NOISE_SD)
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "thread", 0.5)
    assert not any("steady tone" in note for note in result.notes)


@pytest.mark.campaign
def test_red_noise_is_fitted_without_its_wander():
    pulls, _ = draw("thread", lambda n, rng: 0.0, 100, pink(500.0, 2.0)[0])
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(1.0, abs=0.2)

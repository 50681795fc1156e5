"""Synthetic noises of known kind come back with their deviation, slope and kind."""

import math

import numpy as np
import pytest

from platform_daemon.features.fit.series.allan import allan_deviation

TIMES = 15.0 * np.arange(4096)


def white(rng, n=4096):
    return 215.7 + 0.08 * rng.standard_normal(n)


def averaged(fine):
    """Every frame is the mean over its cadence."""
    return 215.7 + fine.reshape(-1, 8).mean(axis=1)


def flicker(rng, n=4096):
    spectrum = np.fft.rfft(rng.standard_normal(32 * n))
    spectrum[1:] /= np.sqrt(np.arange(1, spectrum.size))
    spectrum[0] = 0.0
    return averaged(np.fft.irfft(spectrum)[: 8 * n])


def random_walk(rng, n=4096):
    return averaged(0.01 * np.cumsum(rng.standard_normal(8 * n)))


@pytest.mark.parametrize(
    ("noise", "slope", "name"), [(white, -0.5, "white"), (flicker, 0.0, "flicker"), (random_walk, 0.5, "random_walk")]
)
def test_a_noise_is_recognised_by_its_slope_and_name(noise, slope, name):
    runs = [allan_deviation(TIMES, noise(np.random.default_rng(seed))) for seed in range(10)]
    assert np.mean([r.slope for r in runs]) == pytest.approx(slope, abs=0.04)
    assert sum(r.noise[:5].count(name) for r in runs) >= 40
    assert np.sqrt(np.mean([((r.slope - slope) / r.slope_std) ** 2 for r in runs])) < 2.5


def test_white_noise_averages_down_from_its_own_standard_deviation():
    found = allan_deviation(TIMES, white(np.random.default_rng(7)))
    assert found.cadence_s == 15.0
    assert found.mean_hz == pytest.approx(215.7, abs=0.005)
    assert np.array_equal(found.tau_s, 15.0 * 2 ** np.arange(len(found.tau_s)))
    expected = 0.08 * np.sqrt(15.0 / np.array(found.tau_s))
    assert np.allclose(found.deviation_hz[:6], expected[:6], rtol=0.12)


@pytest.mark.parametrize("noise", [white, flicker, random_walk])
def test_the_confidence_interval_covers_its_share(noise):
    runs = [allan_deviation(TIMES[:256], noise(np.random.default_rng(s), 256)) for s in range(300)]
    mean_square = np.mean([np.square(r.deviation_hz) for r in runs], axis=0)
    for k in range(4):
        inside = np.mean([r.low_hz[k] ** 2 < mean_square[k] < r.high_hz[k] ** 2 for r in runs])
        assert inside == pytest.approx(0.683, abs=0.11), k


def test_a_pure_drift_has_slope_one():
    found = allan_deviation(TIMES, 215.0 + 1e-3 * TIMES)
    assert found.slope == pytest.approx(1.0, abs=1e-6)
    assert found.deviation_hz[0] == pytest.approx(1e-3 * 15.0 / math.sqrt(2.0))


def test_the_definition_holds_for_a_handful_of_numbers():
    # NIST SP 1065, nine-point test suite: normalised to the first averaging time.
    y = np.array([892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0])
    found = allan_deviation(np.arange(9.0), y)
    assert found.deviation_hz[:2] == pytest.approx([91.22945, 85.95287], rel=1e-6)
    assert np.all(np.less(found.low_hz, found.deviation_hz))
    assert np.all(np.greater(found.high_hz, found.deviation_hz))


def test_the_handbooks_thousand_point_suite_is_reproduced():
    n = [1234567890]
    for _ in range(999):
        n.append(16807 * n[-1] % 2147483647)
    found = allan_deviation(np.arange(1000.0), np.array(n) / 2147483647)
    assert found.deviation_hz[0] == pytest.approx(2.922319e-1, rel=1e-6)


def test_a_constant_series_has_no_slope():
    assert allan_deviation(TIMES[:20], np.full(20, 215.0)).slope is None


def test_gaps_and_disorder_are_errors_that_say_where():
    y = white(np.random.default_rng(1), 50)
    gapped = TIMES[:50].copy()
    gapped[20:] += 15.0
    with pytest.raises(ValueError, match="30 s after frame 19"):
        allan_deviation(gapped, y)
    with pytest.raises(ValueError, match="do not rise"):
        allan_deviation(TIMES[:50][::-1], y)
    with pytest.raises(ValueError, match="finite"):
        allan_deviation(TIMES[:50], np.where(np.arange(50) == 3, np.nan, y))
    with pytest.raises(ValueError, match="at least"):
        allan_deviation(TIMES[:3], y[:3])
    jittered = TIMES[:50] + np.random.default_rng(2).uniform(-0.5, 0.5, 50)
    assert allan_deviation(jittered, y).cadence_s == pytest.approx(15.0, rel=0.01)

"""One noise model per series: from blank shots, else from all shots, between the harmonics."""

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.coloured_noise import pink, three
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, with_noise

CLEAN = dmdt(Truth(), 0.24)
SILENCE = np.zeros_like(CLEAN)
HARMONICS = np.array([212.0, 424.0])


def record(signal):
    return RingDownRecord(signal, RATE_HZ, "dmdt")


def series(signals, blank=False):
    noise = SeriesNoise()
    for signal in signals:
        noise.learn(record(signal), blank=blank)
    return noise


def white_shots(clean, shots, seed=0, scale=1.0):
    rng = np.random.default_rng(seed)
    return [with_noise(clean, rng, scale * NOISE_SD) for _ in range(shots)]


def test_nothing_is_known_before_the_first_shot():
    noise = SeriesNoise()
    assert noise.model is None
    assert noise.for_shot(record(white_shots(CLEAN, 1)[0])).model is None


def test_a_series_without_blank_shots_pools_the_noise_between_the_harmonics_of_all():
    noise = series(white_shots(CLEAN, 8))
    assert noise.model.source == "8 shots, outside the harmonics"
    assert noise.model.sd == pytest.approx(NOISE_SD, rel=0.01)
    assert noise.seconds > 0.0


def test_blank_shots_displace_the_others_and_see_under_the_signal():
    noise = series(white_shots(CLEAN, 3))
    for signal in white_shots(SILENCE, 2, seed=1):
        noise.learn(record(signal), blank=True)
    noise.learn(record(white_shots(CLEAN, 1, seed=2)[0]))
    assert noise.model.source == "2 blank shots"
    at = np.searchsorted(noise.model.frequency_hz, HARMONICS)
    assert np.all(noise.model.degrees[at] > 0)


def test_a_rotor_that_swings_in_blank_shots_is_no_noise():
    still_swinging = white_shots(0.003 * dmdt(Truth(), 1.0), 3, seed=1)  # a shot before has not died out yet
    noise, heard = SeriesNoise(), SeriesNoise()
    for signal in still_swinging:
        noise.learn(record(signal), blank=True, rings_hz=212.0)
        heard.learn(record(signal), blank=True)
    at = np.searchsorted(noise.model.frequency_hz, Truth().f_nat_hz)
    far = slice(at + 100, at + 400)
    assert np.max(heard.model.psd[:, at] / np.mean(heard.model.psd[:, far], axis=1)) > 10.0
    assert noise.model.psd[:, at] == pytest.approx(np.mean(noise.model.psd[:, far], axis=1), rel=0.3)
    assert noise.model.degrees[at] == 0.0
    assert noise.model.sd == pytest.approx(NOISE_SD, rel=0.01)


def test_a_rotor_at_rest_hides_nothing_of_the_noise():
    noise = SeriesNoise()
    for signal in white_shots(SILENCE, 3, seed=2):
        noise.learn(record(signal), blank=True, rings_hz=212.0)
    assert np.all(noise.model.degrees[np.searchsorted(noise.model.frequency_hz, HARMONICS)] > 0)


def test_in_a_short_window_a_swing_is_no_tone_but_hum_is():
    rng = np.random.default_rng(5)
    swings, hums = SeriesNoise(), SeriesNoise()
    for signal in white_shots(0.003 * CLEAN, 4, seed=1):
        swings.learn(record(signal), blank=True, rings_hz=212.0)
        hums.learn(record(with_noise(tone(250.0, rng), rng)), blank=True, rings_hz=245.0)
    assert swings.model.tones_hz == ()
    assert hums.model.tones_hz == pytest.approx([250.0], abs=0.5)


def test_pooling_twelve_shots_knows_the_colour_better_than_one():
    make, density = pink(500.0, 1.5)
    wanted = np.sqrt(density(HARMONICS))
    single, many = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        signals = [CLEAN + three(make, NOISE_SD, rng, CLEAN.shape[1]) for _ in range(12)]
        single.append(sd_at(estimate_noise(record(signals[0])), HARMONICS, RATE_HZ) / NOISE_SD[:, None] / wanted)
        many.append(sd_at(series(signals).model, HARMONICS, RATE_HZ) / NOISE_SD[:, None] / wanted)
    assert np.std(many) < 0.5 * np.std(single)
    assert np.mean(many) == pytest.approx(1.0, abs=0.05)


def test_a_louder_shot_keeps_its_own_noise_and_says_so():
    noise = series(white_shots(CLEAN, 6))
    loud = record(white_shots(CLEAN, 1, seed=9, scale=1.5)[0])
    own = noise.for_shot(loud)
    assert "1.5" in own.note
    assert own.model.sd == pytest.approx(1.5 * NOISE_SD, rel=0.05)


def test_shots_like_the_others_never_get_their_own_noise():
    noise = series(white_shots(CLEAN, 4))
    assert all(noise.for_shot(record(s)).note is None for s in white_shots(CLEAN, 400, seed=1))


def test_one_loud_shot_does_not_spoil_the_noise_of_the_series():
    noise = series([*white_shots(CLEAN, 5), *white_shots(CLEAN, 1, seed=3, scale=5.0)])
    assert noise.model.sd == pytest.approx(NOISE_SD, rel=0.02)
    assert noise.model.source.startswith("5 shots")


def test_unusable_shots_teach_nothing():
    broken = white_shots(CLEAN, 1)[0]
    broken[1, 100] = np.nan
    assert series([broken, CLEAN[:, :100]]).model is None


@pytest.mark.long
def test_fits_with_the_noise_of_the_series_scatter_as_predicted_and_name_it():
    make, _ = pink(500.0)
    rng = np.random.default_rng(0)
    blanks = [three(make, NOISE_SD, rng, CLEAN.shape[1]) for _ in range(4)]
    noise = series(blanks, blank=True)
    pulls, draws = [], 60
    for _ in range(draws):
        shot = record(CLEAN + three(make, NOISE_SD, rng, CLEAN.shape[1]))
        found = noise.for_shot(shot)
        assert found.note is None
        result = fit_ring_down(shot, "thread", noise=found.model)
        assert result.noise_source == "4 blank shots"
        assert result.noise_seconds < result.seconds
        pulls.append(errors(result, Truth()) / np.sqrt(np.diag(result.covariance)))
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 4.0 / np.sqrt(draws))
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1.0, abs=0.13)


def tone(frequency_hz, rng):
    phase = 2 * np.pi * frequency_hz * np.arange(CLEAN.shape[1]) / RATE_HZ + rng.uniform(0, 2 * np.pi)
    return np.array([[0.05], [0.03], [0.1]]) * np.sin(phase)


@pytest.mark.long
def test_a_tone_too_near_to_the_signal_to_be_seen_there_is_known_from_blank_shots():
    rng = np.random.default_rng(4)
    noise = series([with_noise(tone(200.0, rng), rng) for _ in range(4)], blank=True)
    assert noise.model.tones_hz == pytest.approx([200.0], abs=0.5)
    assert noise.model.sd == pytest.approx(NOISE_SD, rel=0.02)
    pulls = []
    for _ in range(40):
        result = fit_ring_down(record(with_noise(CLEAN + tone(200.0, rng), rng)), "thread", noise=noise.model)
        assert result.verdict == "good", result.reason
        assert any(note.startswith("steady tone at 200.") or "199.9" in note for note in result.notes)
        pulls.append(errors(result, Truth()) / np.sqrt(np.diag(result.covariance)))
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1.0, abs=0.2)

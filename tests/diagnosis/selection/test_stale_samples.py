"""Samples that repeat the one before, in swings whose samples are known."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.selection.stale_samples import stale_samples, without_stale_samples
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.record import RingDownRecord

RATE_HZ = 100.0
TIME_S = np.arange(6000) / RATE_HZ


def swing(digit=1e-6, noise=1e-3):
    """Of a linear spring, rounded to a digit."""
    angle = 0.5 * np.exp(-0.02 * TIME_S) * np.cos(2.0 * np.pi * 1.3 * TIME_S)
    angle += np.random.default_rng(3).normal(0.0, noise, TIME_S.size)
    return digit * np.round(angle / digit)


def repeated(angle, places):
    out = angle.copy()
    out[places] = out[places - 1]
    return out


def shot(angle):
    record = RingDownRecord(samples=angle[None], sampling_rate_hz=RATE_HZ, quantity="angle")
    return DiagnosisShot("swing", record, estimate_noise(record))


PLACES = np.sort(np.random.default_rng(5).choice(np.arange(10, 5990, 7), 30, replace=False))


def test_each_repeated_sample_is_found_and_no_other():
    assert np.array_equal(stale_samples(repeated(swing(), PLACES)), PLACES)
    assert stale_samples(swing()).size == 0


@pytest.mark.parametrize("digit", [1e-4, 2e-3, 2e-2])
def test_neighbours_that_a_coarse_encoder_makes_equal_are_not_stale(digit):
    assert np.count_nonzero(np.diff(swing(digit)) == 0.0) > 10
    assert stale_samples(swing(digit)).size == 0


@pytest.mark.parametrize("digits_of_noise", [0.2, 1.0, 2.4, 3.5, 6.0, 10.0])
def test_neither_are_those_of_a_fast_one(digits_of_noise):
    """Of a swing so slow for its rate that neighbours differ by noise alone."""
    angle = np.cos(np.arange(60_000) * 1e-3) * 2e3 + np.random.default_rng(8).normal(0.0, digits_of_noise, 60_000)
    assert stale_samples(1e-4 * np.round(angle)).size == 0


def test_a_rotor_at_rest_and_a_record_that_holds_each_value_are_left_alone():
    at_rest = np.concatenate([swing()[:5000], np.full(1000, swing()[5000])])
    assert stale_samples(at_rest).size == 0
    assert stale_samples(np.repeat(swing(), 2)).size == 0
    assert stale_samples(np.zeros(100)).size == 0


@pytest.mark.parametrize("digits", [3, 4, 5, 6])
def test_nor_are_angles_with_so_many_significant_digits(digits):
    angle = np.degrees(swing(1e-9, noise=3e-4))
    assert stale_samples(np.array([float(f"{each:.{digits}g}") for each in angle])).size == 0


def test_the_noise_of_a_series_is_measured_again():
    plain, bad = shot(swing()), shot(repeated(swing(), PLACES))
    pooled = replace(bad, noise=replace(bad.noise, source="1 shot, outside the harmonics"))
    (mended,), _ = without_stale_samples([pooled])
    assert bad.noise.sd[0] > 1.1 * plain.noise.sd[0]
    assert mended.noise.sd[0] == pytest.approx(plain.noise.sd[0], rel=0.03)
    given = replace(bad, noise=replace(bad.noise, source="given"))
    assert without_stale_samples([given])[0][0].noise is given.noise


def test_they_are_interpolated_and_told():
    plain, bad = shot(swing()), shot(repeated(swing(), PLACES))
    (mended,), (told,) = without_stale_samples([bad])
    left = mended.record.samples - plain.record.samples
    assert np.flatnonzero(left[0]).tolist() == PLACES.tolist()
    assert np.abs(left).max() < 6e-3  # the noise of the neighbours
    assert told.id == "stale_samples"
    assert f"30 samples repeat the one before and are interpolated, the first {PLACES[0]}" in told.where
    assert without_stale_samples([plain]) == ([plain], [])


def test_a_diagnosis_says_so_and_finds_nothing_missing():
    bad = shot(repeated(swing(), PLACES))
    report = diagnosis_report(diagnose_shots([replace(bad, name="camera")], model_named("thread_small_angle")))
    assert report.verdict == "nothing_missing"
    assert [f.id for f in report.integrity] == ["stale_samples"]

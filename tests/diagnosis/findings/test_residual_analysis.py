"""The anatomy of residuals, on residuals whose anatomy is known."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.findings.residual_analysis import (
    HARMONICS,
    analyse_residual,
    scatter,
    sliding_windows,
    typical_shot,
)
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.torque_response import sample_motion
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.features.diagnose.load_shots import load_diagnosis_input
from tests.kit.specimen_files import THREAD, pendulum, swing


@pytest.fixture(scope="module")
def clean():
    specimen = load_diagnosis_input([THREAD])
    with shot_pool() as pool:
        prepared, _ = initial_fits(specimen.shots, specimen.model, pool)
        yield fit_jointly(prepared, Hypothesis(specimen.model), pool)


def with_added(at, extra):
    """The fit unchanged, the first shot's data with something added."""
    shot = at.prepared[0].shot
    record = replace(shot.record, samples=shot.record.samples + extra)
    return replace(at, prepared=(replace(at.prepared[0], shot=replace(shot, record=record)), *at.prepared[1:]))


def test_a_clean_residual_is_white_in_every_view(clean):
    seen = analyse_residual(clean, 0)
    assert seen.residual.shape == (3, seen.time_s.size)
    assert seen.whiteness == pytest.approx(np.ones(3), abs=0.05)
    assert seen.in_band == pytest.approx(np.ones(3), abs=0.2)
    assert seen.spectrum.lines == ()
    over = seen.harmonics.size / seen.harmonics.sd
    # Amplitudes of two normal parts: mean square 2.
    assert np.mean(over**2) == pytest.approx(2.0, abs=0.35)


def test_a_tone_is_one_line_at_its_place(clean):
    shot = clean.prepared[0].shot
    t = np.arange(shot.record.samples.shape[1]) / shot.rate_hz
    size = 0.3 * shot.noise.sd[1]
    extra = np.zeros_like(shot.record.samples)
    extra[1] = size * np.sin(2 * np.pi * 333.0 * t)
    lines = analyse_residual(with_added(clean, extra), 0).spectrum.lines
    assert [line.channel for line in lines] == [1]
    assert lines[0].frequency_hz == pytest.approx(333.0, abs=1.0)
    assert lines[0].amplitude == pytest.approx(size, rel=0.2)


def test_a_harmonic_of_the_swing_is_found_on_its_local_axis(clean):
    prepared, state = clean.prepared[0], clean.states[0]
    motion = sample_motion(prepared, clean.hypothesis.model, state)
    phase = np.interp(
        np.arange(prepared.shot.record.samples.shape[1]) / prepared.shot.rate_hz,
        prepared.time_s,
        np.unwrap(motion.phase),
    )
    size = 0.5 * float(prepared.shot.noise.sd.max())
    extra = state.observation.rotation[:, 2:] * (size * np.sin(3 * phase))
    found = analyse_residual(with_added(clean, extra), 0).harmonics
    assert found.axes == ("u", "v", "w")
    third = HARMONICS.index(3)
    assert np.median(found.sine[2, third]) == pytest.approx(size, rel=0.1)
    others = np.delete(found.size / found.sd, third, axis=1)
    assert np.mean(others**2) == pytest.approx(2.0, abs=0.4)
    assert np.all(np.diff(found.angle_rad) < 0.0)


def test_an_offset_at_the_start_shows_there(clean):
    shot = clean.prepared[0].shot
    extra = np.zeros_like(shot.record.samples)
    t = np.arange(extra.shape[1]) / shot.rate_hz
    extra[0] = 3.0 * shot.noise.sd[0] * np.exp(-t / 0.01)
    seen = analyse_residual(with_added(clean, extra), 0)
    assert seen.at_start[0] > 2.0
    assert seen.whiteness[0] < 1.2
    assert seen.at_start[1:] == pytest.approx(np.ones(2), abs=0.2)


def test_windows_along_a_clean_shot_agree(clean):
    found = sliding_windows(clean, 0)
    assert found is not None
    assert found.flatness("lambda_per_s").probability > 1e-3


def test_two_shots_have_a_scatter_and_one_has_none(clean):
    with shot_pool() as pool:
        courses = {s.name: s for s in scatter(clean, pool)}
        alone = replace(
            clean, prepared=clean.prepared[:1], states=clean.states[:1], linear=clean.linear[:1]
        )  # fmt: skip
        assert scatter(alone, pool) == ()
    f = courses["f_nat_hz"]
    assert f.values.shape == f.sd.shape == (2,)
    assert f.drift_per_shot == pytest.approx(f.values[1] - f.values[0])
    assert typical_shot(clean) in (0, 1)


def test_a_long_swing_of_a_pendulum_has_windows_too(tmp_path):
    specimen = load_diagnosis_input([pendulum(tmp_path, *swing(seconds=24.0))], "thread_small_angle")
    with shot_pool() as pool:
        prepared, _ = initial_fits(specimen.shots, specimen.model, pool)
        at = fit_jointly(prepared, Hypothesis(specimen.model), pool)
        found = sliding_windows(at, 0)
    assert found is not None
    assert found.course("f_nat_hz")[0].size >= 6
    assert found.flatness("f_nat_hz").probability > 1e-3
    assert analyse_residual(at, 0).harmonics.axes == ("angle",)

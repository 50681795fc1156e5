"""A motion of one angle stays in its plane, whatever the coils mix; one with a part along the axis does not."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.rigid_body.plane_test import PlaneTest, ShotInPlane, plane_test
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with


def plane_of(change):
    shots, _ = shots_with("thread", (), count=2)
    changed = [replace(s, record=replace(s.record, samples=change(s.record.samples.copy()))) for s in shots]
    with shot_pool() as pool:
        prepared, _ = initial_fits(changed, THREAD, pool)
        return plane_test(prepared)


def leaking(samples):
    samples[2] += 0.02 * samples[0]
    return samples


def rolling(samples):
    """A side mode along z of a fortieth of the signal."""
    samples[2] += 0.025 * np.abs(samples).max() * np.sin(0.0143 * np.arange(samples.shape[1]))
    return samples


@pytest.mark.long
@pytest.mark.parametrize("change", [lambda samples: samples, leaking])
def test_what_the_coils_mix_is_no_motion_out_of_the_plane(change):
    found = plane_of(change)
    assert not found.leaves
    assert [s.ratio for s in found.shots] == pytest.approx([1.0, 1.0], abs=0.05)


@pytest.mark.long
def test_a_motion_along_the_axis_leaves_the_plane_in_every_shot():
    found = plane_of(rolling)
    assert found.leaves
    assert min(found.share) > 5e-3
    assert len(found.share) == len(found.shots)


def in_plane(ratio, noise, swing):
    return ShotInPlane(ratio=ratio, sd=0.024, noise=noise, signal=swing, swing_rad=swing)


FAR = in_plane(1.85, 1e-3, 0.7)


@pytest.mark.parametrize(
    ("other", "alike"),
    [
        (in_plane(1.02, 1e-3, 0.35), True),  # half the swing
        (
            in_plane(0.9, 1e-3, 0.35),
            False,
        ),  # that surely has less than noise
        (
            in_plane(4.0, 1e-4, 0.35),
            True,
        ),  # seen, but not worth a search
        (
            in_plane(1.02, 1e-3, 0.7),
            False,
        ),  # the same swing: one was disturbed
        (
            in_plane(1.02, 4e-3, 0.7),
            True,
        ),  # the same swing in more noise
        (in_plane(1.02, 1e-3, 1.4), False),  # more should show more
        (in_plane(1.81, 1e-3, 0.7), True),
    ],
)
def test_a_shot_may_hide_it_where_it_swings_less_or_its_noise_is_larger(other, alike):
    found = PlaneTest(shots=(other, FAR, other))
    assert found.leaves is alike
    assert found.may_leave is alike


def test_of_one_shot_less_is_a_hint_than_where_the_others_must_hide_it():
    hint, none = (ShotInPlane(ratio=r, sd=0.02, noise=5e-3, signal=0.7, swing_rad=0.7) for r in (1.1, 1.0))
    assert PlaneTest(shots=(hint, hint)).may_leave
    assert not PlaneTest(shots=(hint, hint)).leaves
    assert not PlaneTest(shots=(hint, none)).may_leave


def test_what_was_taken_for_noise_is_found_again_as_a_side_mode():
    """A line along the axis, which the noise was measured with: without blank shots nothing tells it from noise."""
    shots, _ = shots_with("thread", (), count=1)
    with shot_pool() as pool:
        (prepared,), _ = initial_fits(shots, THREAD, pool)
    quiet = prepared.shot.noise
    frequency_hz = np.linspace(0.0, 2000.0, 401)
    psd = np.array([np.interp(frequency_hz, quiet.frequency_hz, one) for one in quiet.psd])
    near = np.abs(frequency_hz - 90.0) < 20.0
    psd[2, near] *= 40.0
    record, rng = prepared.shot.record, np.random.default_rng(1)
    noise = replace(quiet, frequency_hz=frequency_hz, psd=psd, blank=False)
    samples = record.samples.copy()
    time_s = np.arange(samples.shape[1]) * record.dt_s
    size = np.sqrt(np.trapezoid(39.0 / 40.0 * psd[2, near], frequency_hz[near]))
    samples[2] += np.sqrt(2.0) * size * np.cos(2.0 * np.pi * 90.0 * time_s + rng.uniform())
    seen, hidden = (
        plane_test([replace(prepared, shot=replace(prepared.shot, record=replace(record, samples=samples), noise=n))])
        for n in (noise, replace(noise, blank=True))
    )
    assert seen.shots[0].ratio > 1.3
    assert hidden.shots[0].ratio < 1.2


def test_a_record_of_few_periods_has_the_noise_that_was_measured():
    shots, _ = shots_with("thread", (), count=1)
    with shot_pool() as pool:
        (prepared,), _ = initial_fits(shots, THREAD, pool)
    record = prepared.shot.record
    short = replace(record, samples=record.samples[:, : round(0.01 / record.dt_s)], valid_from=0, valid_to=None)
    noise = replace(prepared.shot.noise, blank=False)
    (one,) = plane_test([replace(prepared, shot=replace(prepared.shot, record=short, noise=noise))]).shots
    assert np.isfinite([one.ratio, one.sd, one.share]).all()


def test_shots_that_stay_in_their_plane_do_not_leave_it():
    assert not PlaneTest(shots=(in_plane(1.0, 1e-3, 0.7),) * 3).may_leave

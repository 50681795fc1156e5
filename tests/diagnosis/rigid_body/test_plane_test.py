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


FAR = ShotInPlane(ratio=1.85, sd=0.024, signal=700.0)


@pytest.mark.parametrize(
    ("other", "alike"),
    [
        (ShotInPlane(ratio=1.02, sd=0.024, signal=330.0), True),  # half the swing
        (ShotInPlane(ratio=0.99, sd=0.024, signal=200.0), True),
        (ShotInPlane(ratio=1.02, sd=0.024, signal=700.0), False),  # the same swing: something disturbed one of them
        (ShotInPlane(ratio=1.02, sd=0.024, signal=1400.0), False),
        (ShotInPlane(ratio=1.81, sd=0.024, signal=700.0), True),
    ],
)
def test_a_shot_may_hide_it_only_where_it_swings_less(other, alike):
    found = PlaneTest(shots=(other, FAR, other))
    assert found.leaves is alike
    assert found.may_leave is alike


def test_shots_that_stay_in_their_plane_do_not_leave_it():
    assert not PlaneTest(shots=(ShotInPlane(ratio=1.0, sd=0.024, signal=700.0),) * 3).may_leave

"""Shots in the lanes of one integration."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.estimation.physics.rigid_rotor.motions import motions_beside
from platform_daemon.estimation.physics.rigid_rotor.rotor import NO_DRIVE, LostRotorError
from platform_daemon.estimation.rotor_fit.parameters import free_parameters
from platform_daemon.estimation.rotor_fit.shot import all_linearised, linearised, residuals
from platform_daemon.estimation.thresholds import THRESHOLDS
from tests.kit.rotor_shots import RATE_HZ, shot_of


@pytest.fixture
def pool():
    with ThreadPoolExecutor(2) as made:
        yield made


def test_shots_of_any_length_and_bearing_leave_beside_each_other_what_each_leaves_alone(pool):
    """The shortest one hardly moves: its steps would not do for the others."""
    lengths = [700, 300, 1200, 500, 900, 400]
    shots = [shot_of("thread", n, (3e-7 * (n - 299), 0.0, 0.0), f_nat_hz=215.0 + 1e-4 * n) for n in lengths]
    shots.insert(2, shot_of("jewel", 800, (4e-4, 0.0, 1e-6)))
    together = residuals(shots, [s.values for s in shots], 0.09, pool)
    for shot, found in zip(shots, together, strict=True):
        alone = shot.residual(shot.values, 0.09)
        assert found.shape == alone.shape == (3 * min(shot.samples.shape[1], 1080),)
        assert np.abs(found - alone).max() < 2e-3  # in standard deviations of the noise
    four = sorted((s for s in shots if s.geometry.bearing == "thread"), key=lambda s: s.samples.shape[1])[:4]
    by_the_first, _ = motions_beside([s.rotor(s.values) for s in four], 700, RATE_HZ)
    off = four[3].whitened(four[3].samples - by_the_first[3]) - four[3].residual(four[3].values, 1.0)
    assert np.abs(off).max() > 8e-3


def test_one_that_cannot_be_followed_is_told_whatever_its_place(pool):
    shots = [shot_of("thread", 400, (2e-4, 0.0, 0.0)) for _ in range(3)]
    for place in range(3):
        values = [s.values for s in shots]
        values[place] = replace(values[place], lambda_per_s=-1e7)
        with pytest.raises(LostRotorError):
            residuals(shots, values, 1.0, pool)


@pytest.mark.parametrize(
    ("name", "start", "held"),
    [("thread", "rest", ""), ("jewel", "rest", ""), ("thread", "swing", ""), ("jewel", "rest", "drive_size"),
     ("thread", "free", "")],
)  # fmt: skip
def test_columns_that_take_no_motion_of_their_own_are_what_small_changes_make(name, start, held, pool):
    """Those of the drive's delay and of m_r, against central differences of whole motions."""
    values = {"start_angle_rad": 0.5, "start_speed_rad_per_s": 200.0} if start != "rest" else {}
    shot = replace(shot_of(name, 700, (3e-4, 0.0, 2e-5), drive_size=1.02, **values), start=start)
    shot = replace(shot, drive=NO_DRIVE) if start == "free" else shot
    free = [p for p in free_parameters(shot.geometry, ("stator_tilt_rad",), start) if p.name != held]
    found = linearised(shot, shot.values, free, 1.0, pool)
    by_name = dict(zip((p.name for p in free), found.columns, strict=True))
    changes = {"m_r_am2": 1e-5, "drive_delay_s": 1e-6, "f_nat_hz": 1e-4, "drive_size": 1e-3}
    assert {"m_r_am2", "f_nat_hz"} <= set(by_name)
    for parameter in set(changes) & set(by_name):
        h, at = changes[parameter], getattr(shot.values, parameter)
        low, high = (shot.residual(replace(shot.values, **{parameter: at + s * h}), 1.0) for s in (-1, 1))
        slope = (low - high) / (2.0 * h)
        assert np.abs(by_name[parameter] - slope).max() < 2e-3 * np.abs(slope).max(), parameter


def test_shots_of_more_than_one_batch_are_linearised_in_their_order(pool):
    shots = [shot_of("thread", 200 + 50 * k, (2e-4, 0.0, 0.0)) for k in range(THRESHOLDS.rigid_rotor.shots_at_once + 2)]
    free = [free_parameters(s.geometry, (), s.start)[:5] for s in shots]
    together = list(all_linearised(shots, [s.values for s in shots], free, 1.0, pool))
    for shot, own, found in zip(shots, free, together, strict=True):
        alone = linearised(shot, shot.values, own, 1.0, pool)
        assert found.expected == 3 * shot.samples.shape[1]
        np.testing.assert_array_equal(found.matrix, alone.matrix)
        np.testing.assert_array_equal(found.gradient, alone.gradient)

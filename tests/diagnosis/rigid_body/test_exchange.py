"""Where the fit with another error begins."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from platform_daemon.diagnosis.rigid_body.exchange import as_far_from
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

DRIVE = CoilDrive(field_t=(2.4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
NUMBERS = ("f_nat_hz", "m_r_am2", "lambda_per_s", "side_damping_per_s", "distance_m", "drive_size")


@pytest.fixture(scope="module")
def shot():
    rotor = true_rotor(rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0), DRIVE)
    v, nothing = rotor.values, np.zeros((3, 1))
    return RotorShot(
        samples=nothing, rate_hz=1.0, sd=np.ones(3), geometry=rotor.geometry, drive=DRIVE, values=v,
        declared=v.rotation,
    )  # fmt: skip


def a_fit(shot, defect, **numbers):
    return SimpleNamespace(defect=defect, shots=(shot,), values=(shot.values.with_numbers(numbers),))


def test_from_the_first_error_itself_it_is_the_other_fit(shot):
    one = a_fit(shot, "stator_tilt_rad", stator_tilt_rad=0.02)
    turn = rotation_from_rodrigues(np.array([0.0, 0.01, 0.0]))
    there = a_fit(
        replace(shot, values=replace(shot.values, rotation=shot.values.rotation @ turn)),
        "lateral_displacement_m", lateral_displacement_m=1e-4, f_nat_hz=shot.values.f_nat_hz + 0.3,
        side_damping_per_s=1.2 * shot.values.side_damping_per_s,
    )  # fmt: skip
    begun = as_far_from(one.values[0], one, there, shot=shot)
    for name in (*NUMBERS, "lateral_displacement_m"):
        assert getattr(begun, name) == pytest.approx(getattr(there.values[0], name), rel=1e-12)
    assert begun.stator_tilt_rad == 0.0
    assert shot.rotor(begun).rotation == pytest.approx(shot.rotor(there.values[0]).rotation, abs=1e-12)


@pytest.mark.parametrize(("size", "short", "other"), [(0.03, 0.02, 1.5e-4), (0.03, 0.0, 1e-4), (0.03, -0.03, 1e-4)])
def test_the_other_error_is_as_large_as_the_first_one_in_its_long_window(shot, size, short, other):
    one = a_fit(shot, "stator_tilt_rad", stator_tilt_rad=short, f_nat_hz=215.0)
    there = a_fit(shot, "lateral_displacement_m", lateral_displacement_m=1e-4, f_nat_hz=215.5)
    long = shot.values.with_numbers({"stator_tilt_rad": size, "f_nat_hz": 215.2, "lambda_per_s": 0.4})
    begun = as_far_from(long, one, there, shot=shot)
    assert begun.lateral_displacement_m == pytest.approx(other)
    assert begun.f_nat_hz == pytest.approx(215.7)
    assert begun.lambda_per_s == pytest.approx(0.4)

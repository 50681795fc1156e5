"""Shots of a rotor whose drive and pose nobody knows: they begin as one angle has them at the first sample."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.rigid_body.rotor_shots import rotor_shots
from platform_daemon.estimation.physics.models import JEWEL
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.rotation import HALF_TURN_ABOUT_U
from tests.kit.estimated_rotors import true_rotor
from tests.kit.one_angle import one_angle_of
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES, LATE = 12000.0, 6000, 40
DRIVE = CoilDrive(field_t=(4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)


@pytest.fixture(scope="module")
def base():
    """One angle's fit of a perfect jewel, whose first samples are not valid."""
    rotor = true_rotor(rigid_specimen("jewel", [0.0, 0.0, -9.81], 5.0), DRIVE)
    return one_angle_of(rotor, JEWEL, None, samples=SAMPLES, rate_hz=RATE_HZ, late=LATE), rotor


@pytest.mark.parametrize("turned", [False, True])
def test_the_motion_begins_with_the_first_valid_sample(base, turned):
    """Whichever of the two orientations that one angle cannot tell apart its fit has found."""
    fit, rotor = base
    if turned:
        state = fit.states[0]
        about_u = replace(state.observation, rotation=state.observation.rotation @ HALF_TURN_ABOUT_U)
        fit = replace(fit, states=(replace(state.mirrored(JEWEL), observation=about_u),))
    (shot,) = rotor_shots(fit)
    assert shot.start == "free"
    assert shot.values.rotation[2, 2] > 0.99
    count = shot.count(0.05)
    found, _ = shot.rotor(shot.values).dm_dt(count, RATE_HZ)
    truth = rotor.dm_dt(SAMPLES, RATE_HZ)[0][:, LATE : LATE + count]
    assert np.linalg.norm(found - truth) < 0.05 * np.linalg.norm(truth)


def test_an_axis_that_is_nearly_upright_is_taken_for_an_upright_one(base):
    fit, _ = base
    (shot,) = rotor_shots(fit)
    assert shot.declared[:, 2] == pytest.approx([0.0, 0.0, 1.0])
    assert shot.declared.T @ shot.declared == pytest.approx(np.eye(3), abs=1e-12)

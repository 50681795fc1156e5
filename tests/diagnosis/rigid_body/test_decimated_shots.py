"""A driven thread's shot is decimated for the fit of its rotor; with one angle it is compared as that is judged."""

import math
from types import SimpleNamespace

import pytest

from platform_daemon.diagnosis.findings.rotor_findings import chi2_beside_one_angle
from platform_daemon.diagnosis.rigid_body.rotor_shots import rotor_shots
from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from tests.kit.estimated_rotors import true_rotor
from tests.kit.one_angle import one_angle_of
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES, LATE = 61035.15625, 30000, 40
DRIVE = CoilDrive(field_t=(2.4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)


def shots_of(bearing, model, drive):
    """(one angle's fit, the rotor's shot, its true values) of a perfect rotor whose first samples are not valid."""
    rotor = true_rotor(rigid_specimen(bearing, [0.0, 0.0, -9.81], 5.0), DRIVE)
    fit = one_angle_of(rotor, model, drive, samples=SAMPLES, rate_hz=RATE_HZ, late=LATE)
    (found,) = rotor_shots(fit)
    return fit, found, rotor.values


def test_the_true_rotor_leaves_noise_of_the_decimated_shot_and_of_the_instants_of_one_angle():
    fit, shot, values = shots_of("thread", THREAD, DRIVE)
    assert shot.samples.shape[1] < SAMPLES / 5
    left = shot.residual(values, math.inf)
    assert float(left @ left) == pytest.approx(shot.noise_share * left.size, rel=5.0 / math.sqrt(left.size))
    rotor = SimpleNamespace(fit=SimpleNamespace(shots=(shot,), values=(values,)))
    (chi2,) = chi2_beside_one_angle(rotor, fit)
    dof = fit.prepared[0].dof
    assert chi2 == pytest.approx(dof, rel=5.0 / math.sqrt(dof))


@pytest.mark.parametrize(("bearing", "model", "drive"), [("jewel", JEWEL, DRIVE), ("thread", THREAD, None)])
def test_a_jewel_and_a_shot_without_a_drive_keep_every_sample(bearing, model, drive):
    _, shot, _ = shots_of(bearing, model, drive)
    assert shot.rate_hz == RATE_HZ
    assert shot.samples.shape[1] > 0.9 * (SAMPLES - LATE)

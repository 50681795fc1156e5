"""The rigid rotors of simulator and estimator share no code; that they agree is the proof of both."""

import numpy as np
import pytest

from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from sim_backend.rotor.rigid_body.motion import move
from sim_backend.rotor.rigid_body.parameters import body_parameters
from sim_backend.rotor.rigid_body.rest import rest_state
from sim_backend.rotor.rotor import effective
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import moment, rigid_specimen

TX_S, START_S, RATE_HZ, SAMPLES = 0.04, 0.05, 500.0, 26
GRAVITY = [1.0, 4.0, -9.0]
CASES = {
    "thread, stator": ("thread", 215e-6, {"stator_tilt_rad": 0.01}),
    "thread, rotor": ("thread", 215e-6, {"rotor_tilt_rad": -0.02, "stator_offset_m": [1e-4, 0.0]}),
    "jewel, stator": ("jewel", 490e-6, {"stator_tilt_rad": 0.0354}),
    "jewel, cup": ("jewel", 490e-6, {"jewel_tilt_rad": 0.02, "stator_offset_m": [-1e-4, 0.0]}),
    "jewel, perfect": ("jewel", 490e-6, {}),
}


def simulated(specimen, field_t, omega):
    """d(moment)/dt over m_r along u, v, w at the samples, (SAMPLES, 3), by the simulator."""
    rotor = effective(specimen)
    p = body_parameters(rotor)
    field = rotor.rotation.T @ np.array([field_t, 0.0, 0.0])
    terms = np.array([[field[0], field[1], omega, -np.pi / 2, 0.0, field[2]]])
    y = rest_state(p, rotor.omega_rad_per_s)
    y = move(0.0, TX_S, y, p, rotor.omega_rad_per_s, terms).internal_state
    out, now = [], TX_S
    for k in range(SAMPLES):
        y = move(now, START_S + k / RATE_HZ, y, p, rotor.omega_rad_per_s).internal_state
        now = START_S + k / RATE_HZ
        out.append(np.cross(y[10:], moment(y, p)))
    return rotor.m_r_am2 * rotor.rotation @ np.array(out).T


@pytest.mark.parametrize("case", CASES)
def test_from_rest_through_a_drive_both_rotors_move_alike(case):
    name, field_t, defects = CASES[case]
    specimen = rigid_specimen(name, GRAVITY, 3.0, defects=defects)
    drive = CoilDrive(
        field_t=(field_t, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=TX_S, rx_start_s=START_S, lag_s=0.0
    )
    ours, _ = true_rotor(specimen, drive).dm_dt(SAMPLES, RATE_HZ)
    theirs = simulated(specimen, field_t, 2 * np.pi * 212.0)
    difference = np.sqrt(np.sum((ours - theirs) ** 2, axis=1) / np.sum(theirs**2))
    print(f"{case}: difference of each axis over the signal: {difference}")
    assert difference.max() < 3e-6
    assert not defects or np.abs(theirs[2]).max() > 1e-3 * np.abs(theirs).max()

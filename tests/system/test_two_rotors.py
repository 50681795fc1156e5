"""The rigid rotors of simulator and estimator share no code; that they agree is the proof of both."""

import numpy as np
import pytest

from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen
from tests.kit.simulated_rotors import START_S, TX_S, simulated

RATE_HZ, SAMPLES = 500.0, 26
GRAVITY = [1.0, 4.0, -9.0]
CASES = {
    "thread, stator": ("thread", 215e-6, {"stator_tilt_rad": 0.01}),
    "thread, rotor": ("thread", 215e-6, {"rotor_tilt_rad": -0.02, "stator_offset_m": [1e-4, 0.0]}),
    "jewel, stator": ("jewel", 490e-6, {"stator_tilt_rad": 0.0354}),
    "jewel, cup": ("jewel", 490e-6, {"jewel_tilt_rad": 0.02, "stator_offset_m": [-1e-4, 0.0]}),
    "jewel, perfect": ("jewel", 490e-6, {}),
}


@pytest.mark.parametrize("case", CASES)
def test_from_rest_through_a_drive_both_rotors_move_alike(case):
    name, field_t, defects = CASES[case]
    specimen = rigid_specimen(name, GRAVITY, 3.0, defects=defects)
    drive = CoilDrive(
        field_t=(field_t, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=TX_S, rx_start_s=START_S, lag_s=0.0
    )
    ours, _ = true_rotor(specimen, drive).dm_dt(SAMPLES, RATE_HZ)
    theirs = simulated(specimen, field_t, 212.0, SAMPLES, RATE_HZ)
    difference = np.sqrt(np.sum((ours - theirs) ** 2, axis=1) / np.sum(theirs**2))
    print(f"{case}: difference of each axis over the signal: {difference}")
    assert difference.max() < 3e-6
    assert not defects or np.abs(theirs[2]).max() > 1e-3 * np.abs(theirs).max()

"""Shots of rotors with a tilted stator, as the fit of the rigid rotor takes them."""

from dataclasses import replace

import numpy as np

from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ = 12000.0
DRIVE = CoilDrive(field_t=(2.15e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)


def shot_of(name, samples, field_t, **values):
    """Of so many zeros, with the rotor's true values; the first sample is later where it is long."""
    x, y, z = field_t
    drive = replace(DRIVE, field_t=(x, y, z), rx_start_s=DRIVE.rx_start_s + 1e-5 * samples / 100)
    specimen = rigid_specimen(name, [0.0, 0.0, -9.81], 8.0, defects={"stator_tilt_rad": 0.02})
    rotor = true_rotor(specimen, drive, **values)
    return RotorShot(
        samples=np.zeros((3, samples)), rate_hz=RATE_HZ, sd=np.array([14e-3, 21e-3, 55e-3]), geometry=rotor.geometry,
        drive=drive, values=rotor.values, declared=rotor.values.rotation,
    )  # fmt: skip

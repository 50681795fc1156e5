"""The simulator and the estimator share no ring-down code; that they agree is the proof of both."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from sim_backend.rotor.motion import move
from sim_backend.rotor.torque import DAMPING, HERTZ, SLOTS, STIFFNESS
from sim_backend.rotor.trajectory import states

RATE_HZ = 125e6 / 2048
CASES = {
    "thread, 15 s": (THREAD, 215.69, 0.40, (0.2465,), 15.0),
    "thread, 70 deg": (THREAD, 150.0, 1.22, (1.0,), 3.0),
    "jewel, 2 s, down to sticking": (JEWEL, 213.25, 0.97, (0.0978, 1324.0), 2.0),
    "jewel, weak friction": (JEWEL, 340.0, 0.6, (0.5, 300.0), 3.0),
}


@pytest.mark.parametrize("case", CASES)
def test_simulator_and_estimator_agree_to_1e_9_of_the_rms_signal_over_the_whole_window(case):
    model, f_nat_hz, amplitude, values, seconds = CASES[case]
    w, theta, n = 2 * math.pi * f_nat_hz, 1.3, round(seconds * RATE_HZ)
    estimated = Trajectory(
        model, MotionParameters(w=w, theta=theta, amplitude=amplitude, values=values), seconds
    ).basis(0, n, 1 / RATE_HZ, DIPOLE)[:2]
    q = np.zeros(SLOTS)
    q[DAMPING], q[STIFFNESS], q[HERTZ] = 2 * values[0], w**2, values[1] if len(values) > 1 else 0.0
    motion = move(0.0, seconds + theta / w, amplitude, 0.0, q)
    phi, phi_dot = states(motion.pieces, theta / w + np.arange(n) / RATE_HZ)
    simulated = np.stack([phi_dot * np.cos(phi), -phi_dot * np.sin(phi)]) / w
    difference = math.sqrt(np.sum((simulated - estimated) ** 2) / np.sum(simulated**2))
    print(f"{case}: rms difference {difference:.1e} of the rms signal")
    assert difference < 1e-9

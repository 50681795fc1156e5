"""The simulator's rotor of five degrees of freedom from rest through a drive, for comparison with that of the fit."""

import numpy as np

from sim_backend.rotor.rigid_body.motion import move
from sim_backend.rotor.rigid_body.parameters import body_parameters
from sim_backend.rotor.rigid_body.rest import rest_state
from sim_backend.rotor.rotor import effective
from tests.kit.rigid_rotors import moment

TX_S, START_S = 0.04, 0.05


def simulated(specimen, field_t, frequency_hz, samples, rate_hz):
    """dm/dt, (3, samples) A m^2/s, world axes, after a sine along x from rest on."""
    rotor = effective(specimen)
    p = body_parameters(rotor)
    field = rotor.rotation.T @ np.array([field_t, 0.0, 0.0])
    terms = np.array([[field[0], field[1], 2 * np.pi * frequency_hz, -np.pi / 2, 0.0, field[2]]])
    y = rest_state(p, rotor.omega_rad_per_s)
    y = move(0.0, TX_S, y, p, rotor.omega_rad_per_s, terms).internal_state
    out, now = [], TX_S
    for k in range(samples):
        y = move(now, START_S + k / rate_hz, y, p, rotor.omega_rad_per_s).internal_state
        now = START_S + k / rate_hz
        out.append(np.cross(y[10:], moment(y, p)))
    return rotor.m_r_am2 * rotor.rotation @ np.array(out).T

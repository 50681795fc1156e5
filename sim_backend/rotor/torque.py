"""Every torque on the rotor, per inertia, in rad/s^2: the right-hand side of its equation of motion.

phi'' = drive(t, phi, phi', z) - sgn(phi') friction(t, phi, |phi'|)

A new effect needs a slot in the parameter array and a line in `drive` (a smooth torque) or in `friction` (a torque that
opposes the motion and can hold the rotor at rest); the integrator does not change.  Hidden torques are in
`extra_torque`, those with an internal state z in `internal_state`.
"""

from __future__ import annotations

from math import cos, exp, sin

import numpy as np
from numpy.typing import NDArray

from sim_backend.hidden_effects.listing import HiddenEffects

from .extra_torque import KINKS, SLOTS, SMOOTH, fill, opposing, smooth
from .internal_state import torque as internal_torque
from .kernel import kernel
from .rotor import Rotor

DAMPING = 0  # 2 lambda, 1/s
STIFFNESS = 1  # omega_nat^2, rad^2/s^2
HERTZ = 2  # T_f/I at phi = 0, rad/s^2
MOMENT = 3  # m_r/I, rad/(s^2 T)
BACK_UU, BACK_UV, BACK_VV = 4, 5, 6  # damping by the rotor's own current in the coils, 1/s, see `back_action`
# Slots from 7 on belong to `extra_torque`.

# One term of the field at the rotor: b_u, b_v (T), omega (rad/s), phase (rad), rate (1/s), for
# b exp(-rate tau) cos(omega tau + phase); a constant, a sine and a decaying current are all of this form.
FIELD_U, FIELD_V, FIELD_OMEGA, FIELD_PHASE, FIELD_RATE = 0, 1, 2, 3, 4
FIELD_SLOTS = 5


def parameters(
    rotor: Rotor,
    conductance: NDArray[np.float64] | None = None,
    hidden_effects: HiddenEffects = (),
    drift_from_s: float | None = None,
    now_s: float = 0.0,
) -> NDArray[np.float64]:
    """The parameter array of a rotor: (SLOTS,) float64.

    conductance: (2, 2) float64, T^2/(A V), sum over the coils of b b^T Re(1/Z) in the axes u, v; None: no back-action.
    drift_from_s, now_s: see `extra_torque.fill`.
    """
    q = np.zeros(SLOTS)
    q[DAMPING] = 2 * rotor.lambda_per_s
    q[STIFFNESS] = rotor.omega_rad_per_s**2
    q[HERTZ] = rotor.tf_over_i_rad_per_s2
    q[MOMENT] = rotor.m_r_am2 / rotor.inertia_kg_m2
    if conductance is not None:
        back = rotor.m_r_am2**2 / rotor.inertia_kg_m2 * conductance
        q[BACK_UU], q[BACK_UV], q[BACK_VV] = back[0, 0], back[0, 1], back[1, 1]
    fill(q, hidden_effects, drift_from_s, (rotor.friction_waves, rotor.frequency_waves), now_s)
    return q


@kernel
def field(tau: float, terms: NDArray[np.float64]) -> tuple[float, float]:
    """Coil field at the rotor along u and v, T, `tau` seconds after the terms' time zero; terms: (n, FIELD_SLOTS)."""
    b_u = 0.0
    b_v = 0.0
    for i in range(terms.shape[0]):
        shape = cos(terms[i, 2] * tau + terms[i, 3])
        if terms[i, 4] != 0.0:
            shape *= exp(-terms[i, 4] * tau)
        b_u += terms[i, 0] * shape
        b_v += terms[i, 1] * shape
    return b_u, b_v


@kernel
def back_action(sine: float, cosine: float, phi_dot: float, q: NDArray[np.float64]) -> float:
    """Braking by the current that the rotor's EMF drives through the coils (eq:u(t,p,R) and reciprocity), rad/s^2."""
    return -(q[4] * sine * sine - 2.0 * q[5] * sine * cosine + q[6] * cosine * cosine) * phi_dot


@kernel
def drive(
    tau: float,
    phi: float,
    phi_dot: float,
    q: NDArray[np.float64],
    terms: NDArray[np.float64],
    z: NDArray[np.float64],
) -> float:
    """Sum of the smooth torques, rad/s^2: viscous damping, restoring torque, excitation T_Exc = m x B (after eq:T_m),
    back-action."""
    sine = sin(phi)
    cosine = cos(phi)
    total = -q[0] * phi_dot - q[1] * sine
    if terms.shape[0] > 0:
        b_u, b_v = field(tau, terms)
        total += q[3] * (b_v * cosine - b_u * sine)
    if q[6] != 0.0 or q[4] != 0.0:
        total += back_action(sine, cosine, phi_dot, q)
    if q[SMOOTH] != 0.0:
        total += smooth(tau, phi, phi_dot, sine, cosine, q)
    if z.size > 0:
        total += internal_torque(phi, sine, z, q)
    return total


@kernel
def friction(tau: float, phi: float, speed: float, q: NDArray[np.float64]) -> float:
    """Level of all torques that oppose the motion, >= 0, rad/s^2: Hertz contact T_f cos^(4/3) phi (eq:tf(phi)), and the
    hidden ones.

    speed: of phi in the direction of the motion.  Beyond 90 deg the contact carries no load.
    """
    level = 0.0
    cosine = cos(phi)
    if q[2] != 0.0 and cosine > 0.0:
        level = q[2] * cosine ** (4.0 / 3.0)
    if q[KINKS] != 0.0:
        level = opposing(tau, level, speed, q)
    return level


@kernel
def has_kinks(q: NDArray[np.float64]) -> bool:
    """True if a torque is not smooth where the velocity changes sign; only then the turning points are located."""
    return bool(q[2] != 0.0 or q[KINKS] != 0.0)

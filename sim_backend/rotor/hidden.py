"""Undeclared torques with a state of their own: memory, a gap that breathes, a second mode.

The state z: (STATES,) float64, or (0,) if none of them acts.  z = 0 is relaxed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .extra_torque import (
    AMPLITUDE,
    AMPLITUDE_RATE,
    BRISTLE,
    BRISTLE_REACH,
    GAP,
    GAP_DAMPING,
    GAP_OMEGA,
    MODE,
    MODE_DAMPING,
    MODE_OMEGA,
    MODE_ORDER,
    OMEGA_SQUARED,
    RELAXATION,
    RELAXATION_RATE,
)
from .kernel import kernel

RELAXING, BENT, REMEMBERED, STRETCH, STRETCHING, SECOND, SECOND_SPEED = 0, 1, 2, 3, 4, 5, 6
STATES = 7
RINGING = (STRETCH, SECOND)
NONE = np.zeros(0)


def relaxed(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """The state at rest that the parameters ask for: (STATES,) or (0,)."""
    return np.zeros(STATES) if np.any(q[[RELAXATION, BRISTLE, AMPLITUDE, GAP, MODE]]) else NONE


def rings(state: NDArray[np.float64]) -> float:
    """How far gap and second mode are from rest, rad or relative."""
    return float(np.max(np.abs(state[list(RINGING)]))) if state.size else 0.0


@kernel
def torque(phi: float, sine: float, z: NDArray[np.float64], q: NDArray[np.float64]) -> float:
    """What the hidden states add to the torque, rad/s^2."""
    total = -z[RELAXING] - q[AMPLITUDE] * z[REMEMBERED] * phi
    if q[BRISTLE] != 0.0:
        total -= q[BRISTLE] * z[BENT] / q[BRISTLE_REACH]
    if q[GAP] != 0.0:
        total -= q[OMEGA_SQUARED] * sine * ((1.0 + z[STRETCH]) ** -3.0 - 1.0)
    if q[MODE_ORDER] == 2.0:
        return float(total + q[MODE] * z[SECOND] * phi)
    return float(total + q[MODE] * z[SECOND])


@kernel
def rates(phi, phi_dot, cosine, sign, z, q, out):  # type: ignore[no-untyped-def]
    """Time derivative of the state, into out (STATES,); sign: direction of the motion."""
    out[RELAXING] = q[RELAXATION] * phi_dot - q[RELAXATION_RATE] * z[RELAXING]
    if q[BRISTLE] != 0.0:
        out[BENT] = phi_dot * (1.0 - sign * z[BENT] / q[BRISTLE_REACH])
    out[REMEMBERED] = 2.0 * phi * phi_dot - q[AMPLITUDE_RATE] * z[REMEMBERED]
    if q[GAP] != 0.0:
        pull = q[GAP] * (1.0 - cosine * (1.0 + z[STRETCH]) ** -4.0)
        out[STRETCH] = z[STRETCHING]
        out[STRETCHING] = q[GAP_OMEGA] ** 2 * (pull - z[STRETCH]) - q[GAP_DAMPING] * z[STRETCHING]
    if q[MODE] != 0.0:
        push = q[MODE] * (0.5 * phi * phi if q[MODE_ORDER] == 2.0 else phi)
        out[SECOND] = z[SECOND_SPEED]
        out[SECOND_SPEED] = push - q[MODE_OMEGA] ** 2 * z[SECOND] - q[MODE_DAMPING] * z[SECOND_SPEED]

"""Hidden torques with an internal state: memory, a breathing gap, a second mode.

The internal state is z: (STATES,) float64, or (0,) if none of these torques acts.  z = 0 is relaxed.  The equations are
in `hidden_effects/internal_states.py`.
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
from .pieces import NO_INTERNAL_STATE

RELAXING, BENT, REMEMBERED, STRETCH, STRETCHING, SECOND, SECOND_SPEED = 0, 1, 2, 3, 4, 5, 6
STATES = 7
RINGING = (STRETCH, SECOND)


def relaxed(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """The relaxed state for the torques in q: (STATES,) or (0,)."""
    return np.zeros(STATES) if np.any(q[[RELAXATION, BRISTLE, AMPLITUDE, GAP, MODE]]) else NO_INTERNAL_STATE


def rings(state: NDArray[np.float64]) -> float:
    """Largest deviation of gap and second mode from rest, relative or rad."""
    return float(np.max(np.abs(state[list(RINGING)]))) if state.size else 0.0


@kernel
def torque(phi: float, sine: float, z: NDArray[np.float64], q: NDArray[np.float64]) -> float:
    """Torque of the internal states, rad/s^2."""
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
    """Write the time derivative of z into out (STATES,); sign: direction of the motion."""
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

"""A motion as pieces of polynomials: the layout of a piece, and the state at the end.

Apart from the kernels that make the pieces, so that who only describes a shot does not load the compiler.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NODES = 8
"""Gauss nodes of a step, and coefficients of each of its polynomials."""

# One piece, a row: start s, length s, angle and speed at the start, then the coefficients of powers of x = -1 ... 1 of
# the acceleration, of g_u = -phi' sin phi and of g_v = phi' cos phi (dm/dt = m_r (g_u e_u + g_v e_v), eq:projection).
START, LENGTH, ANGLE, SPEED, ACCEL, G_U, G_V = 0, 1, 2, 3, 4, 4 + NODES, 4 + 2 * NODES
PIECE_SLOTS = 4 + 3 * NODES
NO_FIELD = np.zeros((0, 5))
NO_INTERNAL_STATE = np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A part of the motion and the state at its end.

    pieces: (n, PIECE_SLOTS) float64 in time order; phi_rad, phi_dot_rad_per_s: at the end; stuck: True if dry friction
    holds the rotor at the end; internal_state: at the end, (STATES,) or (0,), see `rotor/internal_state.py`; of a rigid
    body the whole state, see `rigid_body/acceleration.py`.
    """

    pieces: NDArray[np.float64]
    phi_rad: float
    phi_dot_rad_per_s: float
    stuck: bool
    internal_state: NDArray[np.float64]

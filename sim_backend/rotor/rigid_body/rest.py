"""Equilibrium of the rigid rotor, and coordinates of small motions about it.

The coordinates, (5,) float64, are rotations of n about the two axes perpendicular to it, and three rotations of the
rotor, all in the frame whose third axis is n at rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from drivers.errors import ConfigError

from .acceleration import BODY_MOMENT, DAMPING, MU, N_DOT, OMEGA, SIDE_DAMPING, STATES, N, Q, rates
from .motion import NO_FIELD

FARTHEST = 0.8  # of a rotation of n, rad
BALANCED = 1e-6  # of omega_nat^2: largest acceleration at rest
COORDINATES = 5


def straight() -> NDArray[np.float64]:
    """The state at rest of a resonator without defects: (STATES,)."""
    y = np.zeros(STATES)
    y[N + 2] = y[Q] = 1.0
    return y


def frame(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) float64: columns are two axes perpendicular to n, the first the nearest to u, and n."""
    n = y[N : N + 3]
    first = np.array([1.0, 0.0, 0.0]) - n[0] * n
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(n, first), n])


def moved(y: NDArray[np.float64], small: NDArray[np.float64]) -> NDArray[np.float64]:
    """The state (STATES,) without speed at coordinates `small` (5,) about y."""
    axes = frame(y)
    out = np.zeros(STATES)
    out[N : N + 3] = Rotation.from_rotvec(axes[:, :2] @ small[:2]).apply(y[N : N + 3])
    turn = Rotation.from_rotvec(axes @ small[2:]) * Rotation.from_quat(y[Q:OMEGA], scalar_first=True)
    out[Q:OMEGA] = turn.as_quat(scalar_first=True)
    return out


def with_speed(y: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
    """The state y with speeds (5,), rad/s, of the coordinates."""
    axes = frame(y)
    out = y.copy()
    out[N_DOT:Q] = np.cross(axes[:, :2] @ speed[:2], y[N : N + 3])
    out[OMEGA:] = axes @ speed[2:]
    return out


def acceleration(y: NDArray[np.float64], at: NDArray[np.float64], p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Accelerations (5,), rad/s^2, of the coordinates about y in a state `at` near it."""
    out = np.zeros(STATES)
    rates(0.0, at, p, NO_FIELD, out)
    axes = frame(y)
    second = out[N_DOT:Q]
    return np.array([-(axes[:, 1] @ second), axes[:, 0] @ second, *(axes.T @ out[OMEGA:])])


def frictionless(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same parameters without friction and damping."""
    out = p.copy()
    out[[MU, DAMPING, SIDE_DAMPING]] = 0.0
    return out


def rest_state(p: NDArray[np.float64], omega_rad_per_s: float) -> NDArray[np.float64]:
    """The state of equilibrium (STATES,), friction neglected.  Raises ConfigError if there is none nearby.

    A jewel's rotor is free to rotate about its own moment; of these equilibria the nearest to `straight` is returned.
    """
    smooth, start = frictionless(p), straight()

    def pull(small: NDArray[np.float64]) -> NDArray[np.float64]:
        return acceleration(start, moved(start, small), smooth) / omega_rad_per_s**2

    found = least_squares(pull, np.zeros(COORDINATES), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    if np.abs(found.x).max() > FARTHEST or np.abs(pull(found.x)).max() > BALANCED:
        raise ConfigError(
            "the rotor has no position of rest near the main axis",
            where="the resonator's [defects] and rotor.gravity_m_per_s2",
            why=f"forces balance nowhere within {FARTHEST} rad",
            remedy="make the defects smaller",
        )
    return moved(start, found.x)


def distance_from_rest(
    y: NDArray[np.float64], rest: NDArray[np.float64], p: NDArray[np.float64], omega_rad_per_s: float
) -> float:
    """Distance of a state from rest: the largest angle, rad, by which n or the moment deviates or will swing."""
    moment = p[BODY_MOMENT : BODY_MOMENT + 3] / np.linalg.norm(p[BODY_MOMENT : BODY_MOMENT + 3])
    here, there = (Rotation.from_quat(s[Q:OMEGA], scalar_first=True).apply(moment) for s in (y, rest))
    deviation = max(float(np.abs(y[N : N + 3] - rest[N : N + 3]).max()), float(np.abs(here - there).max()))
    swing = max(float(np.abs(y[N_DOT:Q]).max()), float(np.abs(y[OMEGA:]).max())) / omega_rad_per_s
    return max(deviation, swing)

"""Small oscillations about rest: frequencies and decay of main and side modes, by linear analysis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .acceleration import ARM, INERTIA, JEWEL, LINK, MASS, MU
from .rest import COORDINATES, acceleration, moved, with_speed

STEP = 1e-4  # rad, of the differences
MAIN = 4  # coordinate: rotation about n


@dataclass(frozen=True, kw_only=True)
class Mode:
    """One mode.

    frequency_hz; decay_per_s: of the amplitude; shape: (5,) complex, coordinates of `rest`, the largest 1.
    """

    frequency_hz: float
    decay_per_s: float
    shape: NDArray[np.complex128]


@dataclass(frozen=True)
class Modes:
    """The mode with the largest share of rotation about the axis, and all others by ascending frequency."""

    main: Mode
    sides: tuple[Mode, ...]


def modes(rest: NDArray[np.float64], p: NDArray[np.float64], *, rolling: bool | None = None) -> Modes:
    """Modes about an equilibrium (STATES,) with parameters p (SLOTS,).

    rolling: a jewel's rotor rolls without slip; None: it does so if there is friction.  Dry friction, which small
    motions of the main mode would not overcome, is neglected.
    """
    smooth = p.copy()
    smooth[MU] = 0.0
    stiffness, damping = _jacobians(rest, smooth)
    to_all, from_all = _kinematics(p, bool(p[JEWEL] and p[MU]) if rolling is None else rolling)
    stiffness, damping = from_all @ stiffness @ to_all, from_all @ damping @ to_all
    size = len(stiffness)
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [stiffness, damping]])
    values, vectors = np.linalg.eig(matrix)
    keep = [k for k in range(2 * size) if values[k].imag > 1e-3 * np.abs(values).max()]
    found = []
    for k in sorted(keep, key=lambda k: values[k].imag):
        shape = to_all @ vectors[:size, k]
        biggest = shape[np.argmax(np.abs(shape))]
        found.append(
            Mode(frequency_hz=values[k].imag / (2 * np.pi), decay_per_s=-values[k].real, shape=shape / biggest)
        )
    weight = np.array([p[MASS] * p[LINK] ** 2] * 2 + [p[INERTIA]] * 3)
    shares = [weight[MAIN] * abs(m.shape[MAIN]) ** 2 / (weight @ np.abs(m.shape) ** 2) for m in found]
    main = int(np.argmax(shares))
    return Modes(found[main], tuple(m for k, m in enumerate(found) if k != main))


def _jacobians(rest: NDArray[np.float64], p: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Accelerations by coordinates, 1/s^2, and by speeds, 1/s; each (5, 5)."""
    by_place, by_speed = np.zeros((COORDINATES, COORDINATES)), np.zeros((COORDINATES, COORDINATES))
    for k, unit in enumerate(np.eye(COORDINATES)):
        high, low = (acceleration(rest, moved(rest, s * STEP * unit), p) for s in (1.0, -1.0))
        by_place[:, k] = (high - low) / (2 * STEP)
        high, low = (acceleration(rest, with_speed(rest, s * unit), p) for s in (1.0, -1.0))
        by_speed[:, k] = (high - low) / 2
    return by_place, by_speed


def _kinematics(p: NDArray[np.float64], rolling: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Matrices from the free coordinates to all five, (5, k), and from forces on all to the free ones, (k, 5).

    Rolling: -L n' = r omega x n, so the rotor rotates by -L/r times the rotation of n.
    """
    if not rolling:
        return np.eye(COORDINATES), np.eye(COORDINATES)
    to_all = np.zeros((COORDINATES, 3))
    to_all[0, 0] = to_all[1, 1] = to_all[4, 2] = 1.0
    to_all[2, 0] = to_all[3, 1] = -p[LINK] / p[ARM]
    mass = np.diag([p[MASS] * p[LINK] ** 2] * 2 + [p[INERTIA]] * 3)
    return to_all, np.asarray(np.linalg.solve(to_all.T @ mass @ to_all, to_all.T @ mass))

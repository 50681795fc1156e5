"""Evaluates angle and speed at any instant from the pieces of a motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .kernel import kernel
from .pieces import NODES


@kernel
def _state(row, t):  # type: ignore[no-untyped-def]
    half = 0.5 * row[1]
    x = (t - row[0]) / half - 1.0
    first = 0.0
    second = 0.0
    edge = -1.0  # (-1)^(k+1)
    power = x
    for k in range(NODES):
        coefficient = row[4 + k] / (k + 1)
        first += coefficient * (power - edge)
        second += coefficient * ((power * x + edge) / (k + 2) - edge * (x + 1.0))
        power *= x
        edge = -edge
    return row[2] + half * (row[3] * (x + 1.0) + half * second), row[3] + half * first


@kernel
def _fill(pieces, times, phi, phi_dot):  # type: ignore[no-untyped-def]
    j = 0
    for i in range(times.size):
        while j < pieces.shape[0] - 1 and pieces[j, 0] + pieces[j, 1] < times[i]:
            j += 1
        phi[i], phi_dot[i] = _state(pieces[j], times[i])


def states(
    pieces: NDArray[np.float64], times_s: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Angle, rad, and speed, rad/s, at ascending times (n,), s, within the pieces; each (n,) float64."""
    phi, phi_dot = np.empty(times_s.size), np.empty(times_s.size)
    _fill(pieces, np.ascontiguousarray(times_s, dtype=np.float64), phi, phi_dot)
    return phi, phi_dot


def energy_amplitude_rad(phi_rad: float, phi_dot_rad_per_s: float, omega_rad_per_s: float) -> float:
    """Peak angle of the undamped orbit through a state, rad (equ:ODE_norm); pi if the rotor would turn over."""
    cosine = np.cos(phi_rad) - 0.5 * (phi_dot_rad_per_s / omega_rad_per_s) ** 2
    return float(np.arccos(max(cosine, -1.0)))


def largest_angle_rad(pieces: NDArray[np.float64]) -> float:
    """Largest |phi| at the ends of all pieces, rad; with dry friction these include every turning point."""
    return float(np.max(np.abs(pieces[:, 2]))) if pieces.size else 0.0

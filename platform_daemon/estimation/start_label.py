"""The paper's label (phi_max, psi_start) of a start state, and its exact derivatives.

phi(0) = phi_max cos(psi), phi'(0) = -w sqrt(2 - 2 cos(phi_max)) sin(psi): eq:dotvarphimax and the lines before it.
The labelled orbit is not the orbit through the state (it is one only at psi = 0, 90, 180, 270 degrees), so phi_max
is a label and not the real peak angle.
"""

from __future__ import annotations

import math

import numpy as np

from .arrays import Array


class NoLabelError(ArithmeticError):
    """The state has more energy than any phi_max <= pi can label."""


def state_of_label(phi_max_rad: float, psi_rad: float) -> tuple[float, float]:
    """(phi, v) with v = phi'/w of the label."""
    return phi_max_rad * math.cos(psi_rad), -2.0 * math.sin(0.5 * phi_max_rad) * math.sin(psi_rad)


def _excess(phi_max: float, phi: float, v: float) -> float:
    """cos^2 + sin^2 - 1 for a trial phi_max; falls with phi_max."""
    return (phi / phi_max) ** 2 + (v / (2.0 * math.sin(0.5 * phi_max))) ** 2 - 1.0


def _solve_phi_max(phi: float, v: float) -> float:
    """Root of _excess by bisection: certain, and 60 steps are cheap for one call per fit."""
    low, high = 0.5 * max(abs(phi), abs(v)), math.pi
    if low == 0.0 or _excess(high, phi, v) > 0.0:
        raise NoLabelError(f"no phi_max <= 180 degrees labels the state phi = {phi:.4g} rad, phi'/w = {v:.4g}")
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if _excess(middle, phi, v) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def label_of_state(phi: float, v: float) -> tuple[float, float, Array]:
    """(phi_max in rad, psi in [0, 2 pi), d(phi_max, psi)/d(phi, v) of shape (2, 2)).

    Raises:
        NoLabelError: at rest, or beyond 180 degrees.
    """
    phi_max = _solve_phi_max(phi, v)
    half = 0.5 * phi_max
    x = phi / phi_max
    y = -v / (2.0 * math.sin(half))
    d_x = np.array([1.0 / phi_max, 0.0])
    d_y = np.array([0.0, -1.0 / (2.0 * math.sin(half))])
    x_max = -x / phi_max
    y_max = -0.5 * y / math.tan(half)
    # x^2 + y^2 = 1 stays true: x (d_x + x_max d_max) + y (d_y + y_max d_max) = 0.
    d_max = -(x * d_x + y * d_y) / (x * x_max + y * y_max)
    d_psi = x * (d_y + y_max * d_max) - y * (d_x + x_max * d_max)
    psi = math.atan2(y, x) % (2.0 * math.pi)
    return phi_max, psi if psi < 2.0 * math.pi else 0.0, np.vstack([d_max, d_psi])

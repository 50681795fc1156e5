"""The paper's label (phi_max, psi_start) of a start state, and its exact derivatives.

phi(0) = phi_max cos(psi), phi'(0) = -w sqrt(2 - 2 cos(phi_max)) sin(psi): eq:dotvarphimax and the lines before it.
The labelled orbit is not the orbit through the state (it is one only at psi = 0, 90, 180, 270 degrees), so phi_max
is a label and not the real peak angle.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.physics


class NoInitialConditionsError(ArithmeticError):
    """The state has more energy than any phi_max <= pi can label."""


def state_of_initial_conditions(phi_max_rad: float, psi_rad: float) -> tuple[float, float]:
    """(phi, v) with v = phi'/w of the label."""
    return phi_max_rad * math.cos(psi_rad), -2.0 * math.sin(0.5 * phi_max_rad) * math.sin(psi_rad)


def _solve_phi_max(phi: float, v: float) -> float:
    """Root of (phi / x)^2 + (v / (2 sin(x / 2)))^2 = 1, by Newton's method from below.

    The left side falls with x and is convex up to pi, so the steps reach the root from one side.
    """
    x = max(abs(phi), 2.0 * math.asin(min(1.0, 0.5 * abs(v))))
    if x == 0.0 or not (phi / math.pi) ** 2 + 0.25 * v * v <= 1.0:
        raise NoInitialConditionsError(
            f"no phi_max <= 180 degrees labels the state phi = {phi:.4g} rad, phi'/w = {v:.4g}"
        )
    for _ in range(LIMITS.label_rounds):
        along, across = (phi / x) ** 2, (0.5 * v / math.sin(0.5 * x)) ** 2
        step = (along + across - 1.0) / (2.0 * along / x + across / math.tan(0.5 * x))
        x += step
        if step <= LIMITS.label_close * x:
            break
    return min(x, math.pi)


def initial_conditions_of_state(phi: float, v: float) -> tuple[float, float, Array]:
    """(phi_max in rad, psi in [0, 2 pi), d(phi_max, psi)/d(phi, v) of shape (2, 2)).

    Raises:
        NoInitialConditionsError: at rest, or beyond 180 degrees.
    """
    phi_max = _solve_phi_max(phi, v)
    half = 0.5 * phi_max
    x = phi / phi_max
    y = -v / (2.0 * math.sin(half))
    by_phi = 1.0 / phi_max  # of x
    by_v = -1.0 / (2.0 * math.sin(half))  # of y
    x_max = -x / phi_max
    y_max = -0.5 * y / math.tan(half)
    # x^2 + y^2 = 1 stays true: x (d_x + x_max d_max) + y (d_y + y_max d_max) = 0; d psi = x d_y - y d_x in all.
    share, turn = -1.0 / (x * x_max + y * y_max), x * y_max - y * x_max
    d_max = share * x * by_phi, share * y * by_v
    d_psi = turn * d_max[0] - y * by_phi, turn * d_max[1] + x * by_v
    psi = math.atan2(y, x) % (2.0 * math.pi)
    return phi_max, psi if psi < 2.0 * math.pi else 0.0, np.array([d_max, d_psi])

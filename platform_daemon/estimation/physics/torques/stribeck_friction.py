"""Excess of the Hertz contact's friction at low speed, -sgn(phi') a cos^(4/3)(phi) exp(-|phi'| / v_s).

With the friction itself it makes friction x [1 + strength exp(-|phi'| / v_s)], strength = a / (T_f/I).
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def stribeck_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sigma c0 cos^(4/3)(phi) exp(-|v| / c1) with c0 = a / w^2, c1 = v_s / w > 0."""
    root = max(cos_phi, 0.0) ** (1.0 / 3.0)
    speed = sigma * v
    fall = math.exp(-speed / c[j + 1])
    grad[j] = -sigma * root * cos_phi * fall
    grad[j + 1] = c[j] * grad[j] * speed / (c[j + 1] * c[j + 1])
    return c[j] * grad[j], sigma * c[j] * (4.0 / 3.0) * root * sin_phi * fall, -sigma * c[j] * grad[j] / c[j + 1]


STRIBECK_FRICTION = TorqueTerm(
    "stribeck_friction",
    (
        Coefficient("stribeck_rad_per_s2", "rad/s^2", 2, 2e-4),
        Coefficient("stribeck_speed_rad_per_s", "rad/s", 1, 0.05, hidden=True),
    ),
    stribeck_friction,
    loses_energy=True,
    below_rad=0.5 * math.pi,
)

"""Dry friction that falls with the speed, -sgn(phi') a exp(-|phi'| / v_s): what a Coulomb friction has more at rest.

Together with Coulomb friction it is Stribeck's curve without its viscous part; alone, a friction that fades.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def stribeck_coulomb_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sigma c0 exp(-|v| / c1) with c0 = a / w^2, c1 = v_s / w > 0, |v| = sigma v."""
    speed = sigma * v
    fall = math.exp(-speed / c[j + 1])
    grad[j] = -sigma * fall
    grad[j + 1] = c[j] * grad[j] * speed / (c[j + 1] * c[j + 1])
    return c[j] * grad[j], 0.0, -sigma * c[j] * grad[j] / c[j + 1]


STRIBECK_COULOMB_FRICTION = TorqueTerm(
    "stribeck_coulomb_friction",
    (
        Coefficient("stribeck_coulomb_rad_per_s2", "rad/s^2", 2, 2e-4),
        Coefficient("stribeck_coulomb_speed_rad_per_s", "rad/s", 1, 0.05, hidden=True),
    ),
    stribeck_coulomb_friction,
    loses_energy=True,
)

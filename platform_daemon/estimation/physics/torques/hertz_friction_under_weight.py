"""Dry friction of the Hertz contact under a weight, -sgn(phi') (T_f/I) (cos(phi) + g)^(4/3).

The magnets press the rotor into its cup with F cos(phi) (eq:fm(phi)), its weight along the main axis with g F whatever
the deflection, and the friction goes with the power 4/3 of their sum (eq:a in eq:tf).  T_f/I stays that of the magnets'
pull alone.  g is negative where the weight pulls the rotor out of its cup.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


def hertz_friction_under_weight(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sigma c0 (cos(phi) + c1)^(4/3) with c0 = (T_f/I) / w^2, c1 = g."""
    load = max(cos_phi + c[j + 1], 0.0)
    root = load ** (1.0 / 3.0)
    slope = -sigma * c[j] * (4.0 / 3.0) * root
    grad[j] = -sigma * root * load
    grad[j + 1] = slope
    return c[j] * grad[j], -slope * sin_phi, 0.0


HERTZ_FRICTION_UNDER_WEIGHT = TorqueTerm(
    "hertz_friction",
    (
        Coefficient("tf_over_i_rad_per_s2", "rad/s^2", 2, 7e-4),
        Coefficient("weight_over_pull", "1", 0, 1e-2),
    ),
    hertz_friction_under_weight,
    loses_energy=True,
    below_rad=0.5 * math.pi,
)

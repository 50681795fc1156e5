"""Dry friction of the Hertz contact, -sgn(phi') (T_f/I) cos^(4/3)(phi): eq:Jewel_ODE_norm.

The sign is exact. Beyond 90 degrees the magnets no longer press the rotor into the cup: no contact, no friction.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def hertz_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sigma c cos^(4/3)(phi) with c = (T_f/I) / w^2."""
    root = max(cos_phi, 0.0) ** (1.0 / 3.0)
    grad[j] = -sigma * root * cos_phi
    return c[j] * grad[j], sigma * c[j] * (4.0 / 3.0) * root * sin_phi, 0.0


HERTZ_FRICTION = TorqueTerm(
    "hertz_friction",
    (Coefficient("tf_over_i_rad_per_s2", "rad/s^2", 2, 7e-4),),
    hertz_friction,
    loses_energy=True,
    below_rad=0.5 * math.pi,
)

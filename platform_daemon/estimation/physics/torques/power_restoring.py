"""A restoring torque that grows with a free power of the deflection, -k w^2 a (|phi| / a)^p sgn(phi): p = 3 is a cube.

A wall that comes near, a hull that changes its waterline, a stop of rubber: no single term of a series holds these.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


def power_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -c0 a (|phi| / a)^p sgn(phi) with c1 = p > 1, c2 = a: at the angle a it is c0 times that of a spring."""
    share = abs(phi) / c[j + 2]
    slope = share ** (c[j + 1] - 1.0)
    grad[j] = -phi * slope
    grad[j + 1] = c[j] * grad[j] * math.log(max(share, 1e-300))
    grad[j + 2] = c[j] * grad[j] * (1.0 - c[j + 1]) / c[j + 2]
    return c[j] * grad[j], -c[j] * c[j + 1] * slope, 0.0


POWER_RESTORING = TorqueTerm(
    "power_restoring",
    (
        Coefficient("power_restoring", "1", 0, 1e-2),
        Coefficient("power_restoring_exponent", "1", 0, 4.0, hidden=True),
        Coefficient("power_restoring_angle_rad", "rad", 0, 1.0, hidden=True, held=True),
    ),
    power_restoring,
)

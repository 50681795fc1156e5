"""Dry friction that builds up over an angle d after each turning point A, -s a [1 - exp(-s phi/d) / cosh(A/d)].

s = sgn(phi'). Before it slides, a contact is a spring. Dahl's law for it, dF/dphi = (a/d) (1 - s F/a), has this
solution where a swing turns at +A and -A; A is the turning point of the free swing through the present angle and
velocity, so that no memory is needed. What a half cycle loses must be small against A; d << A is Coulomb friction.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


def dahl_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sigma c0 (1 - g), g = 2 exp(-s/d) / (1 + exp(-2 A/d)) with c0 = a / w^2, c1 = d.

    4 sin^2(A/2) = v^2 + 4 sin^2(phi/2). s is the angle since the turning point: A + sigma phi, and by how much A was
    greater there, the work of this friction since over the slope of the potential, sin A.
    """
    d = c[j + 1]
    size = min(math.sqrt(0.25 * v * v + 0.5 * (1.0 - cos_phi)), 1.0)
    turn = 2.0 * math.asin(size)
    steep = max(2.0 * size * math.sqrt(1.0 - size * size), 1e-9)
    near = max(turn + sigma * phi, 0.0)
    fall = math.exp(-near / d)
    back = math.exp(-2.0 * turn / d)
    loop = 2.0 / (1.0 + back)
    odd = loop * back
    built = loop * (1.0 - fall)
    work = near - d * built
    share = c[j] / steep
    since = max(near + share * work, 0.0)
    left = loop * math.exp(-since / d)
    tau = sigma * c[j] * (left - 1.0)
    slope = sigma * c[j] * left / d  # d tau / d(-s)
    since_near = 1.0 + share * (1.0 - loop * fall)
    since_turn = share * (-built * odd - work * (1.0 - 2.0 * size * size) / steep)
    since_d = share * (loop * fall * near / d - built + built * odd * turn / d)
    by_turn = slope * (odd - since_near - since_turn) / steep
    grad[j] = sigma * (left - 1.0) - slope * work / steep
    grad[j + 1] = slope * ((since - odd * turn) / d - since_d)
    return tau, by_turn * sin_phi - slope * since_near * sigma, by_turn * v


DAHL_FRICTION = TorqueTerm(
    "dahl_friction",
    (
        Coefficient("dahl_rad_per_s2", "rad/s^2", 2, 7e-4),
        Coefficient("dahl_displacement_rad", "rad", 0, 0.03, hidden=True),
    ),
    dahl_friction,
    loses_energy=True,
)

"""What a torque has more or less along one ring-down: x(t) p(phi), where x runs smoothly through knots.

Between two knots x is the cubic of Keys through these and their neighbours, with one slope on either side of a knot;
before the first knot and after the last one it is constant.
Linear pieces have a kink in each knot, over which a step of the integrator reaches: the derivatives by the knots were
5e-4 off, so that fits of 240 of them ended 100 of chi^2 above the least.

p is a law of the angle.  Of dry friction it is -sgn(phi'), or -sgn(phi') (cos(phi) + g)^(4/3) of a Hertz contact under
a weight g; of the restoring torque -sin(phi), so that x is what omega_nat^2 has more.  The knots belong to one shot;
diagnosis/fluctuation estimates them, and no fit moves where they are.
"""

from __future__ import annotations

from functools import lru_cache

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm

FIRST_KNOT = 3  # place among the coefficients
CONSTANT, HERTZ, SINE = 0.0, 1.0, 2.0
"""Laws of the angle: of Coulomb's friction, of that of a Hertz contact, and of the restoring torque."""


@inlined
def torque_course(phi, sin_phi, cos_phi, v, u, c, j, grad, sigma, width):  # type: ignore[no-untyped-def]
    """tau = x(u) p(phi); c0: w times the step of the knots, c1: the law, c2: g, then x / w^2.

    Before the first knot and after the last one x stays as it is there.
    """
    for k in range(width):
        grad[j + k] = 0.0
    if c[j + 1] == SINE:
        sigma = 1.0
        law = sin_phi
        law_phi = cos_phi
        law_g = 0.0
    elif c[j + 1] == HERTZ:
        load = max(cos_phi + c[j + 2], 0.0)
        root = load ** (1.0 / 3.0)
        law = root * load
        law_phi = -(4.0 / 3.0) * root * sin_phi
        law_g = (4.0 / 3.0) * root
    else:
        law = 1.0
        law_phi = 0.0
        law_g = 0.0
    place = u / c[j]
    last = width - 4
    k = 0
    if place > 0.0:  # not so where the motion is lost and there is no number
        k = int(min(place, last - 1.0))
    t = max(min(place - k, 1.0), 0.0)
    inside = 0.0 <= place <= last
    x = 0.0
    rate = 0.0
    for m in range(4):
        if m == 0:
            part = ((1.0 - 0.5 * t) * t - 0.5) * t
            slope = (2.0 - 1.5 * t) * t - 0.5
        elif m == 1:
            part = (1.5 * t - 2.5) * t * t + 1.0
            slope = (4.5 * t - 5.0) * t
        elif m == 2:
            part = ((2.0 - 1.5 * t) * t + 0.5) * t
            slope = (4.0 - 4.5 * t) * t + 0.5
        else:
            part = (0.5 * t - 0.5) * t * t
            slope = (1.5 * t - 1.0) * t
        here = j + 3 + min(max(k + m - 1, 0), last)
        x += part * c[here]
        rate += slope * c[here]
        grad[here] -= sigma * part * law
    rate = rate / c[j] if inside else 0.0
    grad[j] = sigma * rate * place * law
    grad[j + 2] = -sigma * x * law_g
    return -sigma * x * law, -sigma * x * law_phi, 0.0, -sigma * rate * law


@lru_cache
def torque_course_term(knots: int, *, frozen: bool = False) -> TorqueTerm:
    """The term with so many knots, at least 2; frozen: without derivatives by them."""
    steps = (
        Coefficient("course_step_s", "s", -1, 1e2, hidden=True, held=True),
        Coefficient("course_law", "1", 0, 1.0, hidden=True, held=True),
        Coefficient("course_weight", "1", 0, 1e-2),
    )
    more = (Coefficient(f"course_{k}_rad_per_s2", "rad/s^2", 2, 1e-4) for k in range(knots))
    return TorqueTerm("torque_course", (*steps, *more), torque_course, timed=True, frozen=frozen)

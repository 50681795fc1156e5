"""Viscous damping that grows with the deflection, -2 kappa phi^2 phi'."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def angle_dependent_damping(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -2 c phi^2 v with c = kappa / w."""
    grad[j] = -2.0 * phi * phi * v
    return c[j] * grad[j], -4.0 * c[j] * phi * v, -2.0 * c[j] * phi * phi


ANGLE_DEPENDENT_DAMPING = TorqueTerm(
    "angle_dependent_damping",
    (Coefficient("kappa_per_s", "1/s", 1, 2e-4),),
    angle_dependent_damping,
    loses_energy=True,
)

"""Dry friction of constant size, -sgn(phi') a: eq:Jewel_ODE_norm_simp, the approximation before the Hertz contact."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def coulomb_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sigma c with c = a / w^2."""
    grad[j] = -sigma
    return -sigma * c[j], 0.0, 0.0


COULOMB_FRICTION = TorqueTerm(
    "coulomb_friction", (Coefficient("coulomb_rad_per_s2", "rad/s^2", 2, 7e-4),), coulomb_friction, loses_energy=True
)

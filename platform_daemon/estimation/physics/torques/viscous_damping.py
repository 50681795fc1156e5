"""Viscous damping -2 lambda phi': eq:Thread_ODE_norm with lambda = w / (2 Q), eq:lambda."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def viscous_damping(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -2 c v with c = lambda / w."""
    grad[j] = -2.0 * v
    return -2.0 * c[j] * v, 0.0, -2.0 * c[j]


VISCOUS_DAMPING = TorqueTerm(
    "viscous_damping", (Coefficient("lambda_per_s", "1/s", 1, 2e-4),), viscous_damping, loses_energy=True
)

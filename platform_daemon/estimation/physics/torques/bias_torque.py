"""A constant torque that does not depend on the deflection, +t: a twisted thread, an eccentric weight."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def bias_torque(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = c with c = t / w^2."""
    grad[j] = 1.0
    return c[j], 0.0, 0.0


BIAS_TORQUE = TorqueTerm(
    "bias_torque", (Coefficient("bias_rad_per_s2", "rad/s^2", 2, 1e-2),), bias_torque, symmetric=False
)

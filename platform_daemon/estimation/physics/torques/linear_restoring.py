"""The restoring torque of the small-angle regime, -phi in place of -sin(phi): after equ:ODE_norm."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import TorqueTerm


@inlined
def linear_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -phi; no coefficient, because w itself is the unit of time."""
    return -phi, -1.0, 0.0


LINEAR_RESTORING = TorqueTerm("linear_restoring", (), linear_restoring)

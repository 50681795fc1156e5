"""A restoring torque that grows with the cube of the deflection, -k3 w^2 phi^3: a spring that stiffens, a wire."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def cubic_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -k3 phi^3."""
    grad[j] = -phi * phi * phi
    return c[j] * grad[j], -3.0 * c[j] * phi * phi, 0.0


CUBIC_RESTORING = TorqueTerm("cubic_restoring", (Coefficient("cubic_restoring", "1", 0, 1e-2),), cubic_restoring)

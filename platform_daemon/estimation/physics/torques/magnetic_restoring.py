"""The restoring torque of the stator magnet, -sin(phi): eq:T_m, eq:omega_nat."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import TorqueTerm


@inlined
def magnetic_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -sin(phi); no coefficient, because w itself is the unit of time."""
    return -sin_phi, -cos_phi, 0.0


MAGNETIC_RESTORING = TorqueTerm("magnetic_restoring", (), magnetic_restoring)

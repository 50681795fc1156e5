"""An elastic torque in addition to the magnetic one, -k w^2 phi; w stays the frequency of the declared sine term."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def torsion_stiffness(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -k phi."""
    grad[j] = -phi
    return -c[j] * phi, -c[j], 0.0


TORSION_STIFFNESS = TorqueTerm(
    "torsion_stiffness", (Coefficient("torsion_stiffness", "1", 0, 1e-2),), torsion_stiffness
)

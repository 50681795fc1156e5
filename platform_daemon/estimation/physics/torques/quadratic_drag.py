"""Drag of a turbulent flow, -b phi' |phi'|."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def quadratic_drag(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -b v |v|, |v| = sigma v: smooth within a half cycle; b is the same in both units of time."""
    grad[j] = -sigma * v * v
    return c[j] * grad[j], 0.0, -2.0 * sigma * c[j] * v


QUADRATIC_DRAG = TorqueTerm(
    "quadratic_drag", (Coefficient("quadratic_drag_per_rad", "1/rad", 0, 1e-3),), quadratic_drag, loses_energy=True
)

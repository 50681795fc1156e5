"""A restoring torque that weakens with the deflection: -sin(phi) [1 - beta (1 - cos(phi))]; here its second part."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def restoring_anharmonicity(phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = beta sin(phi) (1 - cos(phi))."""
    grad[j] = sin_phi * (1.0 - cos_phi)
    return c[j] * grad[j], c[j] * (cos_phi * (1.0 - cos_phi) + sin_phi * sin_phi), 0.0


RESTORING_ANHARMONICITY = TorqueTerm(
    "restoring_anharmonicity", (Coefficient("anharmonicity", "1", 0, 1e-2),), restoring_anharmonicity
)

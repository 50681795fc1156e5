"""Torque terms: each a small module with its derivatives; the place in these lists is the number in dispatch.py."""

from __future__ import annotations

from .angle_dependent_damping import ANGLE_DEPENDENT_DAMPING
from .bias_torque import BIAS_TORQUE
from .coulomb_friction import COULOMB_FRICTION
from .dispatch import TIMED_FROM
from .frequency_drift import FREQUENCY_DRIFT
from .hertz_friction import HERTZ_FRICTION
from .linear_restoring import LINEAR_RESTORING
from .magnetic_restoring import MAGNETIC_RESTORING
from .quadratic_drag import QUADRATIC_DRAG
from .restoring_anharmonicity import RESTORING_ANHARMONICITY
from .stribeck_friction import STRIBECK_FRICTION
from .torque_term import Coefficient, TorqueTerm
from .torsion_stiffness import TORSION_STIFFNESS
from .viscous_damping import VISCOUS_DAMPING

AUTONOMOUS = (
    MAGNETIC_RESTORING,
    VISCOUS_DAMPING,
    HERTZ_FRICTION,
    COULOMB_FRICTION,
    LINEAR_RESTORING,
    QUADRATIC_DRAG,
    ANGLE_DEPENDENT_DAMPING,
    RESTORING_ANHARMONICITY,
    TORSION_STIFFNESS,
    BIAS_TORQUE,
    STRIBECK_FRICTION,
)
TIMED = (FREQUENCY_DRIFT,)
TERMS: dict[str, TorqueTerm] = {t.name: t for t in (*AUTONOMOUS, *TIMED)}
# Coefficients that phi -> -phi gives the other sign.
OF_OTHER_SIGN_IN_MIRROR = frozenset(t.coefficients[0].name for t in TERMS.values() if not t.symmetric)


def code_of(term: TorqueTerm) -> int:
    """The number by which dispatch.py knows a term; ValueError if it is not listed."""
    return TIMED_FROM + TIMED.index(term) if term.timed else AUTONOMOUS.index(term)


__all__ = [
    "ANGLE_DEPENDENT_DAMPING",
    "AUTONOMOUS",
    "BIAS_TORQUE",
    "COULOMB_FRICTION",
    "FREQUENCY_DRIFT",
    "HERTZ_FRICTION",
    "LINEAR_RESTORING",
    "MAGNETIC_RESTORING",
    "OF_OTHER_SIGN_IN_MIRROR",
    "QUADRATIC_DRAG",
    "RESTORING_ANHARMONICITY",
    "STRIBECK_FRICTION",
    "TERMS",
    "TIMED",
    "TORSION_STIFFNESS",
    "VISCOUS_DAMPING",
    "Coefficient",
    "TorqueTerm",
    "code_of",
]

"""Torque terms: each a small module with its derivatives; the place in these lists is the number in dispatch.py.

angle_dependent_damping: Viscous damping that grows with the deflection, -2 kappa phi^2 phi'.
bias_torque: A constant torque that does not depend on the deflection, +t: a twisted thread, an eccentric weight.
coulomb_friction: Dry friction of constant size, -sgn(phi') a: eq:Jewel_ODE_norm_simp, the approximation before the
    Hertz contact.
cubic_restoring: A restoring torque that grows with the cube of the deflection, -k3 w^2 phi^3: a spring that stiffens,
    a wire.
dahl_friction: Dry friction that builds up over an angle d after each turning point A, -s a [1 - exp(-s phi/d) /
    cosh(A/d)].
dispatch: The one place where the kernel meets the terms: a number in, the term's acceleration and derivatives out.
frequency_drift: A natural frequency that changes while the resonator rings: f_nat(t) = f_nat (1 + d t), t = 0 at
    the first sample.
frequency_settling: A natural frequency that settles while the resonator rings: f_nat(t) = f_nat [1 + d tau (1 -
    exp(-t / tau))].
hertz_friction: Dry friction of the Hertz contact, -sgn(phi') (T_f/I) cos^(4/3)(phi): eq:Jewel_ODE_norm.
hertz_friction_under_weight: Dry friction of the Hertz contact under a weight, -sgn(phi') (T_f/I) (cos(phi) +
    g)^(4/3).
linear_restoring: The restoring torque of the small-angle regime, -phi in place of -sin(phi): after equ:ODE_norm.
magnetic_restoring: The restoring torque of the stator magnet, -sin(phi): eq:T_m, eq:omega_nat.
own_terms: Torque terms of other packages, found by entry point: each is compiled by itself, so that no kernel is
    compiled again.
power_restoring: A restoring torque that grows with a free power of the deflection, -k w^2 a (|phi| / a)^p sgn(phi):
    p = 3 is a cube.
quadratic_drag: Drag of a turbulent flow, -b phi' |phi'|.
restoring_anharmonicity: A restoring torque that weakens with the deflection: -sin(phi) [1 - beta (1 - cos(phi))].
stribeck_coulomb_friction: Dry friction that falls with the speed, -sgn(phi') a exp(-|phi'| / v_s): what a Coulomb
    friction has more at rest.
stribeck_friction: Excess of the Hertz contact's friction at low speed, -sgn(phi') a cos^(4/3)(phi) exp(-|phi'| /
    v_s).
torsion_stiffness: An elastic torque in addition to the magnetic one, -k w^2 phi.
viscous_damping: Viscous damping -2 lambda phi': eq:Thread_ODE_norm with lambda = w / (2 Q), eq:lambda.
"""

from __future__ import annotations

from platform_daemon.estimation.numerics.separate_functions import address_of
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm

from .angle_dependent_damping import ANGLE_DEPENDENT_DAMPING
from .bias_torque import BIAS_TORQUE
from .coulomb_friction import COULOMB_FRICTION
from .cubic_restoring import CUBIC_RESTORING
from .dahl_friction import DAHL_FRICTION
from .dispatch import TIMED_FROM
from .frequency_drift import FREQUENCY_DRIFT
from .frequency_settling import FREQUENCY_SETTLING
from .hertz_friction import HERTZ_FRICTION
from .hertz_friction_under_weight import HERTZ_FRICTION_UNDER_WEIGHT
from .linear_restoring import LINEAR_RESTORING
from .magnetic_restoring import MAGNETIC_RESTORING
from .own_terms import own_terms
from .power_restoring import POWER_RESTORING
from .quadratic_drag import QUADRATIC_DRAG
from .restoring_anharmonicity import RESTORING_ANHARMONICITY
from .stribeck_coulomb_friction import STRIBECK_COULOMB_FRICTION
from .stribeck_friction import STRIBECK_FRICTION
from .torque_course import torque_course
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
    STRIBECK_COULOMB_FRICTION,
    CUBIC_RESTORING,
)
TIMED = (FREQUENCY_DRIFT, FREQUENCY_SETTLING)
# Terms that are compiled by themselves, without a decorator: no kernel is compiled again for one of them.
SEPARATE_BUILT_IN: tuple[TorqueTerm, ...] = (POWER_RESTORING, DAHL_FRICTION)
# In the place of a listed term where more is known of the resonator; nobody chooses them by name.
IN_PLACE: tuple[TorqueTerm, ...] = (HERTZ_FRICTION_UNDER_WEIGHT,)
FROM_PACKAGES, BROKEN = own_terms((*AUTONOMOUS, *TIMED, *SEPARATE_BUILT_IN))
SEPARATE = (*SEPARATE_BUILT_IN, *FROM_PACKAGES)
TERMS: dict[str, TorqueTerm] = {t.name: t for t in (*AUTONOMOUS, *TIMED, *SEPARATE)}
# Coefficients that phi -> -phi gives the other sign.
OF_OTHER_SIGN_IN_MIRROR = frozenset(t.coefficients[0].name for t in TERMS.values() if not t.symmetric)


def is_listed(term: TorqueTerm) -> bool:
    """True for a term that the kernel knows."""
    return term in TERMS.values() or term in IN_PLACE or term.function is torque_course


def code_of(term: TorqueTerm) -> int:
    """The number by which dispatch.py knows a term; of a separate term its address in this process, negative if timed.

    Raises:
        ValueError: the term is not listed.
    """
    if term.function is torque_course:
        return TIMED_FROM + len(TIMED)
    if term in SEPARATE or term in IN_PLACE:
        return -address_of(term.function, 4) if term.timed else address_of(term.function, 3)
    return TIMED_FROM + TIMED.index(term) if term.timed else AUTONOMOUS.index(term)


__all__ = [
    "ANGLE_DEPENDENT_DAMPING",
    "AUTONOMOUS",
    "BIAS_TORQUE",
    "BROKEN",
    "COULOMB_FRICTION",
    "CUBIC_RESTORING",
    "DAHL_FRICTION",
    "FREQUENCY_DRIFT",
    "FREQUENCY_SETTLING",
    "FROM_PACKAGES",
    "HERTZ_FRICTION",
    "HERTZ_FRICTION_UNDER_WEIGHT",
    "IN_PLACE",
    "LINEAR_RESTORING",
    "MAGNETIC_RESTORING",
    "OF_OTHER_SIGN_IN_MIRROR",
    "POWER_RESTORING",
    "QUADRATIC_DRAG",
    "RESTORING_ANHARMONICITY",
    "SEPARATE",
    "SEPARATE_BUILT_IN",
    "STRIBECK_COULOMB_FRICTION",
    "STRIBECK_FRICTION",
    "TERMS",
    "TIMED",
    "TORSION_STIFFNESS",
    "VISCOUS_DAMPING",
    "Coefficient",
    "TorqueTerm",
    "code_of",
    "is_listed",
]

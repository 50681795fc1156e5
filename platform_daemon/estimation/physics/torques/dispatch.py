"""The one place where the kernel meets the terms: a number in, the term's acceleration and derivatives out.

The number of a term is its place in AUTONOMOUS (__init__.py of this folder), or TIMED_FROM plus its place in TIMED. The
integrator does not change and is compiled once for all combinations: which terms act is data (`codes`), not code.
The number of a separate term is the address of its function, negative if it is timed.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import part
from platform_daemon.estimation.numerics.separate_functions import call_autonomous, call_timed

from .angle_dependent_damping import angle_dependent_damping
from .bias_torque import bias_torque
from .coulomb_friction import coulomb_friction
from .cubic_restoring import cubic_restoring
from .frequency_drift import frequency_drift
from .frequency_settling import frequency_settling
from .hertz_friction import hertz_friction
from .linear_restoring import linear_restoring
from .magnetic_restoring import magnetic_restoring
from .quadratic_drag import quadratic_drag
from .restoring_anharmonicity import restoring_anharmonicity
from .stribeck_coulomb_friction import stribeck_coulomb_friction
from .stribeck_friction import stribeck_friction
from .torque_course import torque_course
from .torsion_stiffness import torsion_stiffness
from .viscous_damping import viscous_damping

TIMED_FROM = 1000
LARGEST_NUMBER = 0xFFFF  # no operating system places code as low


@part
def acceleration(phi, v, sigma, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Sum of all autonomous terms: (tau, d tau/d phi, d tau/d v); grad gets d tau/d c, float64 (coefficients,).

    codes, widths: int64 (terms,) numbers of the terms and how many coefficients each of them has.
    """
    sin_phi = math.sin(phi)
    cos_phi = math.cos(phi)
    total = 0.0
    total_phi = 0.0
    total_v = 0.0
    j = 0
    for k in range(codes.size):
        f = f_phi = f_v = 0.0
        if codes[k] == 0:
            f, f_phi, f_v = magnetic_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 1:
            f, f_phi, f_v = viscous_damping(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 2:
            f, f_phi, f_v = hertz_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 3:
            f, f_phi, f_v = coulomb_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 4:
            f, f_phi, f_v = linear_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 5:
            f, f_phi, f_v = quadratic_drag(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 6:
            f, f_phi, f_v = angle_dependent_damping(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 7:
            f, f_phi, f_v = restoring_anharmonicity(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 8:
            f, f_phi, f_v = torsion_stiffness(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 9:
            f, f_phi, f_v = bias_torque(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 10:
            f, f_phi, f_v = stribeck_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 11:
            f, f_phi, f_v = stribeck_coulomb_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] == 12:
            f, f_phi, f_v = cubic_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif codes[k] > LARGEST_NUMBER:
            f, f_phi, f_v = call_autonomous(codes[k], phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        total += f
        total_phi += f_phi
        total_v += f_v
        j += widths[k]
    return total, total_phi, total_v


@part
def timed_acceleration(phi, v, u, sigma, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Sum of all timed terms at u = w t: (tau, d tau/d phi, d tau/d v, d tau/d u); grad gets their d tau/d c.

    What moves the natural frequency moves the declared restoring torque, which may be linear.
    """
    linear = False
    for k in range(codes.size):
        linear = linear or codes[k] == 4
    total = 0.0
    total_phi = 0.0
    total_v = 0.0
    total_u = 0.0
    j = 0
    for k in range(codes.size):
        if codes[k] < 0 or TIMED_FROM <= codes[k] <= LARGEST_NUMBER:
            sin_phi = math.sin(phi)
            cos_phi = math.cos(phi)
            law, law_phi = (phi, 1.0) if linear else (sin_phi, cos_phi)
            f = f_phi = f_v = f_u = 0.0
            if codes[k] == TIMED_FROM:
                f, f_phi, f_v, f_u = frequency_drift(phi, law, law_phi, v, u, c, j, grad)
            elif codes[k] == TIMED_FROM + 1:
                f, f_phi, f_v, f_u = frequency_settling(phi, law, law_phi, v, u, c, j, grad)
            elif codes[k] == TIMED_FROM + 2:
                f, f_phi, f_v, f_u = torque_course(phi, sin_phi, cos_phi, v, u, c, j, grad, sigma, widths[k])
            elif codes[k] < 0:
                f, f_phi, f_v, f_u = call_timed(-codes[k], phi, sin_phi, cos_phi, v, u, c, j, grad)
            total += f
            total_phi += f_phi
            total_v += f_v
            total_u += f_u
        j += widths[k]
    return total, total_phi, total_v, total_u

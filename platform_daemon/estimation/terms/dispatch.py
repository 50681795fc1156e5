"""The one place where the kernel meets the terms: a number in, the term's acceleration and derivatives out.

A new term adds its module, two lines here and its entry in terms/__init__.py. The integrator does not change and
is compiled once for all combinations: which terms act is data (`codes`), not code.
"""

from __future__ import annotations

import math

from ..jit import kernel
from .hertz_friction import hertz_friction
from .magnetic_restoring import magnetic_restoring
from .viscous_damping import viscous_damping


@kernel
def acceleration(phi, v, sigma, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Sum of all terms: (tau, d tau/d phi, d tau/d v); grad gets d tau/d c, float64 (coefficients,).

    codes, widths: int64 (terms,) numbers of the terms and how many coefficients each of them has.
    """
    sin_phi = math.sin(phi)
    cos_phi = math.cos(phi)
    total = 0.0
    total_phi = 0.0
    total_v = 0.0
    j = 0
    for k in range(codes.size):
        code = codes[k]
        if code == 0:
            f, f_phi, f_v = magnetic_restoring(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        elif code == 1:
            f, f_phi, f_v = viscous_damping(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        else:
            f, f_phi, f_v = hertz_friction(phi, sin_phi, cos_phi, v, sigma, c, j, grad)
        total += f
        total_phi += f_phi
        total_v += f_v
        j += widths[k]
    return total, total_phi, total_v

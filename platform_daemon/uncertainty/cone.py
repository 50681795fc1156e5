"""How far a direction may be off, where a small rotation of it is uncertain."""

from __future__ import annotations

import math

import numpy as np

from .budget import checked_coverage
from .inputs import Array

_ANGLES = 720  # of the circle, over which the mean of a smooth function is exact to more digits than are told


def cone_angle(rotation: Array, coverage: float, dof: float = math.inf) -> float:
    """Half angle of a cone, rad, that contains any direction fixed to a body with at least that probability.

    rotation: (3, 3) covariance of the small rotation of the body about three axes, rad^2; dof: degrees of freedom of
    it.  At most pi, which says that the direction is not known.  Raises InputError for a coverage that is no
    probability.

    A rotation about a direction itself does not move it, so that two variances a >= b of the three count; the direction
    that is known worst is that about whose axis the rotation is known best, for which they are the two largest.  With
    normal errors, of standard deviation sqrt(a cos^2 t + b sin^2 t) per unit along the angle t of polar coordinates,
    the probability of more than r is the mean over t of exp(-r^2 / 2 (a cos^2 t + b sin^2 t)); with the t distribution
    of n degrees of freedom, of (1 + r^2 / n (a cos^2 t + b sin^2 t))^(-n/2), which for b = 0 is the interval of an
    angle.
    """
    from scipy.optimize import brentq

    checked_coverage(coverage)
    _, b, a = np.linalg.eigvalsh(rotation)
    if a <= 0.0:
        return 0.0
    t = 2.0 * math.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
    along = np.cos(t) ** 2 + max(0.0, b / a) * np.sin(t) ** 2
    n = math.inf if math.isinf(dof) else max(1.0, math.floor(dof + 1e-9))  # cut as for a coverage factor

    def missed(square: float) -> float:
        beyond = np.exp(-0.5 * square / along) if math.isinf(n) else (1.0 + square / (n * along)) ** (-0.5 * n)
        return float(np.mean(beyond)) - (1.0 - coverage)

    tail = 1.0 - coverage
    widest = -2.0 * math.log(tail) if math.isinf(n) else n * (tail ** (-2.0 / n) - 1.0)  # of two that are alike: a = b
    square = widest if missed(widest) >= 0.0 else float(brentq(missed, 0.0, widest))
    return min(math.pi, math.sqrt(square * a))

"""How far a direction may be off, where a small rotation of it is uncertain."""

from __future__ import annotations

import math

import numpy as np

from .budget import checked_coverage
from .inputs import Array

_ANGLES = 720  # of the circle: the mean over a smooth function of it converges with their number, not a power of it


def cone_angle(rotation: Array, coverage: float) -> float:
    """Half angle of a cone, rad, that contains any direction fixed to a body with at least that probability.

    rotation: (3, 3) covariance of the small rotation of the body about three axes, rad^2.  Raises InputError for a
    coverage that is no probability.

    A rotation about a direction itself does not move it, so that two variances a >= b of the three count; the direction
    that is known worst is that about whose axis the rotation is known best, for which they are the two largest.  With
    normal errors, of standard deviation sqrt(a cos^2 t + b sin^2 t) per unit along the angle t of polar coordinates,
    the probability of less than r is the mean over t of 1 - exp(-r^2 / 2 (a cos^2 t + b sin^2 t)).
    """
    from scipy.optimize import brentq

    checked_coverage(coverage)
    _, b, a = np.linalg.eigvalsh(rotation)
    if a <= 0.0:
        return 0.0
    t = 2.0 * math.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
    along = np.cos(t) ** 2 + max(0.0, b / a) * np.sin(t) ** 2

    def missed(square: float) -> float:
        return float(np.mean(np.exp(-0.5 * square / along))) - (1.0 - coverage)

    widest = -2.0 * math.log(1.0 - coverage)  # chi^2 of two: a = b
    if missed(widest) >= 0.0:
        return math.sqrt(widest * a)
    return math.sqrt(a * float(brentq(missed, 0.0, widest)))

"""Several minima that explain a record about equally well."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points
from platform_daemon.estimation.thresholds import THRESHOLDS

from .gauss_newton import covariance
from .problem import Minimum

LIMITS = THRESHOLDS.least_squares


def ambiguity(found: Sequence[Minimum], model: RingDownModel, free: np.ndarray, degrees: int) -> tuple[str, ...]:
    """A warning if starts led to distinct minima of comparable chi2: errors that know of one of them mean little."""
    best = min(found, key=lambda fitted: fitted.normal.chi2)
    scale = max(1.0, best.normal.chi2 / degrees)
    for other in found:
        if other is best or other.normal.chi2 - best.normal.chi2 > LIMITS.comparable_chi2 * scale:
            continue
        if _distance(best, other, model, free) > LIMITS.distinct_sigma * math.sqrt(scale):
            return (
                f"start_ambiguous: {_described(best, degrees)}, but {_described(other, degrees)} from another start",
            )
    return ()


def _distance(best: Minimum, other: Minimum, model: RingDownModel, free: np.ndarray) -> float:
    """Largest difference of frequency, amplitude and coefficients in the best one's standard deviations."""
    sd = np.sqrt(covariance(best.normal, free)[0].diagonal())
    rank = np.cumsum(free) - 1
    one, two = best.state.dynamics, other.state.dynamics
    difference = np.array([two.w - one.w, _apart(one, two, model), *np.subtract(two.values, one.values)])
    return float(
        max((abs(difference[k]) / sd[rank[k + 1]] for k in range(difference.size) if free[k + 1]), default=0.0)
    )


def _apart(one: MotionParameters, two: MotionParameters, model: RingDownModel) -> float:
    """Difference of the amplitudes of two motions, at the size of the first.

    A motion may be counted from any of its turning points: their amplitudes are compared at the same one.
    """
    first, second = sorted((one, two), key=lambda d: -d.theta / d.w)
    later_s = -second.theta / second.w
    here = abs(first.amplitude)
    if not model.time_dependent:
        try:
            times, sizes = turning_points(model, first, later_s)
        except LostTrajectoryError:
            return math.inf
        here = float(sizes[np.argmin(np.abs(times - later_s))])
    return abs(one.amplitude) * (abs(second.amplitude) / here - 1.0)


def _described(fitted: Minimum, degrees: int) -> str:
    """A minimum in a few words."""
    d = fitted.state.dynamics
    return (
        f"chi2/dof = {fitted.normal.chi2 / degrees:.4g} at f_nat = {d.w / (2.0 * math.pi):.6g} Hz and "
        f"{math.degrees(abs(d.amplitude)):.3g} deg"
    )

"""Several minima that explain a record about equally well."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..numerics.arrays import Array
from .gauss_newton import FitState, covariance
from .growing import Fitted

_COMPARABLE = 25.0  # of chi2 over its mean per degree of freedom
_DISTINCT = 10.0  # standard deviations


def ambiguity(found: Sequence[Fitted], free: np.ndarray, degrees: int) -> tuple[str, ...]:
    """A warning if starts led to distinct minima of comparable chi2: errors that know of one of them mean little."""
    best = min(found, key=lambda fitted: fitted.normal.chi2)
    scale = max(1.0, best.normal.chi2 / degrees)
    for other in found:
        if other is best or other.normal.chi2 - best.normal.chi2 > _COMPARABLE * scale:
            continue
        if _distance(best, other, free) > _DISTINCT * math.sqrt(scale):
            return (
                f"start_ambiguous: {_described(best, degrees)}, but {_described(other, degrees)} from another start",
            )
    return ()


def _distance(best: Fitted, other: Fitted, free: np.ndarray) -> float:
    """Largest difference of frequency, amplitude and coefficients in the best one's standard deviations."""
    sd = np.sqrt(covariance(best.normal, free)[0].diagonal())
    rank = np.cumsum(free) - 1
    difference = np.abs(_motion(best.state) - _motion(other.state))
    return float(max((difference[k] / sd[rank[k + 1]] for k in range(difference.size) if free[k + 1]), default=0.0))


def _motion(state: FitState) -> Array:
    """Frequency, size of the amplitude and coefficients."""
    d = state.dynamics
    return np.array([d.w, abs(d.amplitude), *d.values])


def _described(fitted: Fitted, degrees: int) -> str:
    """A minimum in a few words."""
    d = fitted.state.dynamics
    return (
        f"chi2/dof = {fitted.normal.chi2 / degrees:.4g} at f_nat = {d.w / (2.0 * math.pi):.6g} Hz and "
        f"{math.degrees(abs(d.amplitude)):.3g} deg"
    )

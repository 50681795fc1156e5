"""Chebyshev grids: nodes in [-1, 1], the way from values to coefficients, and exact integration matrices."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import chebyshev
from scipy.special import ellipk

from platform_daemon.estimation.thresholds import THRESHOLDS

from .arrays import Array
from .jit import part

LIMITS = THRESHOLDS.physics
MOST_SIZES = LIMITS.most_sizes
EXACT = LIMITS.exact_digits
COARSE = LIMITS.coarse_digits
_FEWEST_SIZES = LIMITS.fewest_sizes


@dataclass(frozen=True, kw_only=True)
class ChebyshevGrid:
    """A grid of m nodes of the first kind, for functions on a half cycle, mapped to the unit interval.

    Attributes:
        nodes: (m,) in (-1, 1), falling from the end to the beginning.
        to_nodes: (m, m); row k holds the values of T_k's share in the node polynomials: Y_node = Y_k to_nodes.
        once: (m + 1, m) integral over the unit interval from its beginning to each node, and to the end.
        twice: (m + 1, m) the same, integrated twice.
    """

    nodes: Array
    to_nodes: Array
    once: Array
    twice: Array

    def weights_at(self, place: float) -> Array:
        """Weights (m,) with which the values at the nodes add up to the value at a place in [-1, 1]."""
        angles = math.acos(min(max(place, -1.0), 1.0)) * np.arange(self.nodes.size)
        return np.asarray(np.cos(angles) @ self.to_nodes)


@cache
def grid(m: int) -> ChebyshevGrid:
    """The grid with m nodes."""
    nodes = np.cos(np.pi * (2 * np.arange(m) + 1) / (2 * m))
    to_nodes = 2.0 / m * chebyshev.chebvander(nodes, m - 1)
    to_nodes[:, 0] *= 0.5
    places = np.append(nodes, 1.0)
    # d s = dx / 2 on the unit interval.
    once = chebyshev.chebint(to_nodes.T, 1, lbnd=-1.0, scl=0.5)
    twice = chebyshev.chebint(once, 1, lbnd=-1.0, scl=0.5)
    return ChebyshevGrid(
        nodes=nodes,
        to_nodes=np.ascontiguousarray(to_nodes.T),
        once=np.ascontiguousarray(chebyshev.chebval(places, once).T),
        twice=np.ascontiguousarray(chebyshev.chebval(places, twice).T),
    )


def nodes_for(amplitude_rad: float, digits: float) -> int:
    """Nodes (a multiple of four) with which a half cycle of this amplitude is represented to so many digits.

    The undamped orbit has its nearest poles at +-i K' above its middle, K from either end: the error of m nodes falls
    like rho^-m with rho = y + sqrt(1 + y^2), y = K'/K. Sensitivities need a few more.
    """
    return _nodes(round(amplitude_rad, 2), digits)


@cache
def _nodes(amplitude_rad: float, digits: float) -> int:
    """The same, for as few amplitudes as differ in it."""
    y = _quarter_period_ratio(amplitude_rad)
    rho = min(y + math.sqrt(1.0 + y * y), LIMITS.fastest_convergence)
    wanted = LIMITS.spare_nodes + math.log(10.0) * digits / math.log(rho)
    return min(LIMITS.most_nodes, max(LIMITS.fewest_nodes, 4 * math.ceil(0.25 * wanted)))


def _quarter_period_ratio(amplitude_rad: float) -> float:
    """K'/K of the undamped orbit."""
    parameter = min(
        max(math.sin(0.5 * amplitude_rad) ** 2, LIMITS.least_elliptic_parameter), 1.0 - LIMITS.elliptic_margin
    )
    return float(ellipk(1.0 - parameter) / ellipk(parameter))


@part
def sizes_for(amplitude_rad, band_ratio, digits):  # type: ignore[no-untyped-def]
    """Sizes at which half cycles between amplitude/band_ratio and amplitude are tabulated, to so many digits.

    What lies nearest is the inverted position, where a half cycle takes forever.
    """
    low = amplitude_rad / band_ratio
    z = (2.0 * math.pi - amplitude_rad - low) / (amplitude_rad - low)
    wanted = math.ceil(1.0 + math.log(10.0) * digits / math.log(z + math.sqrt(z * z - 1.0)))
    return min(MOST_SIZES, max(_FEWEST_SIZES, wanted))

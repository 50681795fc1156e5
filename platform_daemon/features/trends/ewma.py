"""Limits of a two-sided EWMA chart from the false-alarm rate that is requested.

z_i = (1 - w) z_{i-1} + w x_i, z_0 = 0, of independent x with mean 0 and variance 1; alarm when |z| > h. The mean number
of points to an alarm (average run length, ARL) solves a Fredholm equation of the second kind (Crowder, Technometrics 29
(1987) 401), here by Gauss-Legendre nodes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy  # not its parts: they are loaded where they are used, not at every start of the daemon

from platform_daemon.estimation.numerics.arrays import Array

NODES = 101
"""Of the quadrature: the ARL is good to 1e-6 for weights from 0.05 on."""


def ewma_run_length(weight: float, width: float, shift: float = 0.0) -> float:
    """Mean number of points to an alarm, for a mean of `shift` standard deviations.

    width: the limit over the standard deviation of z long after the start, sqrt(w / (2 - w)).
    """
    h = width * steady_std(weight)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    start = np.append(h * nodes, 0.0)[:, None]
    kernel = h * weights * _normal_density((h * nodes - (1.0 - weight) * start) / weight - shift) / weight
    at_nodes = np.linalg.solve(np.eye(NODES) - kernel[:-1], np.ones(NODES))
    return float(1.0 + kernel[-1] @ at_nodes)


def _normal_density(x: Array) -> Array:
    """That of scipy.stats.norm, which takes as long to load as a trend."""
    return np.asarray(np.exp(-np.square(x) / 2.0) / np.sqrt(2.0 * np.pi))


@lru_cache(64)
def ewma_width(weight: float, run_length: float) -> float:
    """Width of the limits that alarms once in `run_length` points, 10 to 1e7, on average when nothing changes."""
    return float(
        scipy.optimize.brentq(lambda width: np.log(ewma_run_length(weight, width) / run_length), 0.2, 7.0, xtol=1e-6)
    )


def steady_std(weight: float) -> float:
    """Standard deviation of z long after the start."""
    return float(np.sqrt(weight / (2.0 - weight)))

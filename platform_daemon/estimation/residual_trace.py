"""The fitted signal at chosen places, from the tables of half swings that a pass over the samples has left behind."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .arrays import Array
from .jit import fast_kernel, fast_part
from .swing_chain import HEAD_DURATION, HEAD_SIDE, HEAD_START

_POINTS = 3  # in a block
_FINE_ENOUGH = 1e-4  # of the signal: what so few points and the coefficients left out may be wrong by


def to_coefficients(values: Array, to_nodes: Array, accuracy: float) -> Array:
    """Chebyshev coefficients of f1, f2, as many as matter, (tables, sizes, 2, k); values (tables, sizes, f, m)."""
    found = values[:, :, :2] @ to_nodes.T
    size = np.abs(found).max(axis=(0, 1))
    matters = (size > 0.01 * accuracy * size.max(axis=1, keepdims=True)).any(axis=0)
    return np.asarray(found[..., : max(2, int(np.flatnonzero(matters)[-1]) + 1)])


def points_in(block: int, accuracy: float) -> tuple[Array, Array]:
    """Places in a block of samples, from its first one on, and weights: with these a smooth signal has its mean.

    accuracy: relative to the signal. Where few points are not enough, all samples are taken: friction bends the
    signal at its turning points, so that a few more would not do.
    """
    return _gauss(block, block if accuracy < _FINE_ENOUGH else min(block, _POINTS))


@lru_cache(32)
def _gauss(block: int, points: int) -> tuple[Array, Array]:
    """Gauss quadrature for sums over `block` equally spaced samples: exact for all if there are as many points."""
    if points == block:
        return np.arange(float(block)), np.full(block, 1.0 / block)
    k = np.arange(1.0, points)
    beside = np.sqrt(k**2 * (block**2 - k**2) / (4.0 * (4.0 * k**2 - 1.0)))
    places, vectors = np.linalg.eigh(np.diag(beside, 1) + np.diag(beside, -1))
    return 0.5 * (block - 1.0) + places, vectors[0] ** 2


@fast_kernel
def fill_model(  # type: ignore[no-untyped-def]
    begin, block, places, shares, dt, w, theta, done, count, heads, weights, mirrored, coefficients, sign2, out
):
    """Add f1, f2 to their means over blocks of `block` samples from sample `begin` on, out (2, blocks).

    places, shares (points,): points_in. heads, weights: the next `count` half swings as walk_swings leaves them,
    coefficients (tables, sizes, 2, k) of f1, f2; sign2: what f2 turns its sign with, 1 for never or -1 for the
    direction. Returns the points added so far; `done` were before.
    """
    points = places.size
    here = np.empty((2, coefficients.shape[3]))
    k = done // points
    j = done - k * points
    for swing in range(count):
        side = heads[swing, HEAD_SIDE]
        table = coefficients[0 if mirrored or side > 0.0 else 1]
        for f in range(2):
            sign = side if f == 0 or sign2 < 0.0 else 1.0
            for i in range(here.shape[1]):
                here[f, i] = 0.0
            for size in range(table.shape[0]):
                for i in range(here.shape[1]):
                    here[f, i] += sign * weights[swing, size] * table[size, f, i]
        scale = 2.0 / heads[swing, HEAD_DURATION]
        while k < out.shape[1]:
            x = scale * (w * dt * (begin + k * block + places[j]) + theta - heads[swing, HEAD_START]) - 1.0
            if x >= 1.0:
                break
            first, second = _sums_at(here, x)
            out[0, k] += shares[j] * first
            out[1, k] += shares[j] * second
            j += 1
            if j == points:
                k += 1
                j = 0
    return k * points + j


@fast_part
def _sums_at(coefficients, x):  # type: ignore[no-untyped-def]
    """Two sums of Chebyshev polynomials, coefficients (2, k), at x, by Clenshaw's recurrence."""
    first = second = first_before = second_before = 0.0
    twice = 2.0 * x
    for k in range(coefficients.shape[1] - 1, 0, -1):
        first, first_before = twice * first + (coefficients[0, k] - first_before), first
        second, second_before = twice * second + (coefficients[1, k] - second_before), second
    return coefficients[0, 0] + x * first - first_before, coefficients[1, 0] + x * second - second_before

"""The fitted signal at chosen places, from the tables of half cycles that a pass over the samples has left behind."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.jit import fast_kernel, fast_part
from platform_daemon.estimation.physics.trajectory.half_cycle_chain import HEAD_DURATION, HEAD_SIDE, HEAD_START
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.least_squares
_TOGETHER = LIMITS.kernel_places


def to_coefficients(values: Array, to_nodes: Array, accuracy: float) -> Array:
    """Chebyshev coefficients of f1, f2, an even number k, at least as many as matter, (tables, sizes, 2, k); values
    (tables, sizes, f, m).
    """
    found = values[:, :, :2] @ to_nodes.T
    size = np.abs(found).max(axis=(0, 1))
    matters = (size > LIMITS.coefficient_error_share * accuracy * size.max(axis=1, keepdims=True)).any(axis=0)
    return np.ascontiguousarray(found[..., : int(np.flatnonzero(matters)[-1]) // 2 * 2 + 2])


def quadrature_points(block: int, accuracy: float) -> tuple[Array, Array]:
    """Places in a block of samples, from its first one on, and weights: with these a smooth signal has its mean.

    accuracy: relative to the signal. Where few points are not enough, all samples are taken: friction bends the
    signal at its turning points, so that a few more would not do.
    """
    return _gauss(block, block if accuracy < LIMITS.block_error_share else min(block, LIMITS.block_points))


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

    places, shares (points,): points_in. heads, weights: the next `count` half cycles as walk_half_cycles leaves them,
    coefficients (tables, sizes, 2, k) of f1, f2; sign2: what f2 turns its sign with, 1 for never or -1 for the
    direction. Returns the points added so far; `done` were before.
    """
    points = places.size
    everything = out.shape[1] * points
    here = np.empty((2, coefficients.shape[3]))
    buffer = np.empty(5 * _TOGETHER)
    for half_cycle in range(count):
        side = heads[half_cycle, HEAD_SIDE]
        table = coefficients[0 if mirrored or side > 0.0 else 1]
        for f in range(2):
            sign = side if f == 0 or sign2 < 0.0 else 1.0
            for i in range(here.shape[1]):
                here[f, i] = 0.0
            for size in range(table.shape[0]):
                for i in range(here.shape[1]):
                    here[f, i] += sign * weights[half_cycle, size] * table[size, f, i]
        scale = 2.0 / heads[half_cycle, HEAD_DURATION]
        inside = _TOGETHER
        while inside == _TOGETHER and done < everything:
            k = done // points
            j = done - k * points
            inside = 0
            while inside < _TOGETHER and done + inside < everything:
                x = scale * (w * dt * (begin + k * block + places[j]) + theta - heads[half_cycle, HEAD_START]) - 1.0
                if x >= 1.0:
                    break
                buffer[inside] = x
                inside += 1
                j += 1
                if j == points:
                    k += 1
                    j = 0
            _sums_at(here, inside, buffer)
            for i in range(inside):
                k = done // points
                j = done - k * points
                out[0, k] += shares[j] * buffer[_TOGETHER + i]
                out[1, k] += shares[j] * buffer[2 * _TOGETHER + i]
                done += 1
    return done


@fast_part
def _sums_at(coefficients, n, buffer):  # type: ignore[no-untyped-def]
    """Two sums of Chebyshev polynomials, coefficients (2, k), k even, at n places.

    buffer (5 _TOGETHER,): places in the first part, then the two sums; then T_k, T_k+1.
    """
    for i in range(n):
        buffer[_TOGETHER + i] = 0.0
        buffer[2 * _TOGETHER + i] = 0.0
        buffer[3 * _TOGETHER + i] = 1.0
        buffer[4 * _TOGETHER + i] = buffer[i]
    for k in range(0, coefficients.shape[1], 2):
        a0 = coefficients[0, k]
        a1 = coefficients[0, k + 1]
        b0 = coefficients[1, k]
        b1 = coefficients[1, k + 1]
        for i in range(n):
            even = buffer[3 * _TOGETHER + i]
            odd = buffer[4 * _TOGETHER + i]
            buffer[_TOGETHER + i] += a0 * even + a1 * odd
            buffer[2 * _TOGETHER + i] += b0 * even + b1 * odd
            twice = 2.0 * buffer[i]
            following = twice * odd - even
            buffer[3 * _TOGETHER + i] = following
            buffer[4 * _TOGETHER + i] = twice * following - odd

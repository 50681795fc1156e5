"""The fitted signal at chosen places, from the tables of half swings that a pass over the samples has left behind."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .arrays import Array
from .jit import fast_kernel
from .swing_chain import HEAD_DURATION, HEAD_SIDE, HEAD_START

_POINTS = 3  # in a block
_FINE_ENOUGH = 1e-4  # of the signal: what so few points and the coefficients left out may be wrong by
_CHUNK = 512


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
    total = points * out.shape[1]
    x = np.empty(_CHUNK)
    even = np.empty(_CHUNK)
    odd = np.empty(_CHUNK)
    first = np.empty(_CHUNK)
    second = np.empty(_CHUNK)
    here = np.empty((2, coefficients.shape[3]))
    swing = 0
    while swing < count:
        side = heads[swing, HEAD_SIDE]
        table = coefficients[0 if mirrored or side > 0.0 else 1]
        for f in range(2):
            for k in range(here.shape[1]):
                here[f, k] = 0.0
            for size in range(table.shape[0]):
                for k in range(here.shape[1]):
                    here[f, k] += weights[swing, size] * table[size, f, k]
        n = 0
        k = done // points
        j = done - k * points
        scale = 2.0 / heads[swing, HEAD_DURATION]
        while n < _CHUNK and done + n < total:
            x[n] = scale * (w * dt * (begin + k * block + places[j]) + theta - heads[swing, HEAD_START]) - 1.0
            if x[n] >= 1.0:
                break
            n += 1
            j += 1
            if j == points:
                k += 1
                j = 0
        for i in range(n):
            even[i] = 1.0
            odd[i] = x[i]
            first[i] = here[0, 0] + here[0, 1] * x[i]
            second[i] = here[1, 0] + here[1, 1] * x[i]
        for k in range(2, here.shape[1]):
            for i in range(n):
                following = 2.0 * x[i] * odd[i] - even[i]
                even[i] = odd[i]
                odd[i] = following
                first[i] += here[0, k] * following
                second[i] += here[1, k] * following
        turned = side if sign2 < 0.0 else 1.0
        k = done // points
        j = done - k * points
        for i in range(n):
            out[0, k] += side * shares[j] * first[i]
            out[1, k] += turned * shares[j] * second[i]
            j += 1
            if j == points:
                k += 1
                j = 0
        done += n
        if n < _CHUNK:
            swing += 1
    return done

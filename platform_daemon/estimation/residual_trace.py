"""The fitted signal at chosen places, from the tables of half swings that a pass over the samples has left behind."""

from __future__ import annotations

import math

import numpy as np

from .arrays import Array
from .jit import fast_kernel
from .swing_chain import HEAD_DURATION, HEAD_SIDE, HEAD_START

_NEGLIGIBLE = 1e-6  # of the largest coefficient: far below any noise


def to_coefficients(values: Array, to_nodes: Array) -> Array:
    """Chebyshev coefficients of f1, f2, as many as matter, (tables, sizes, 2, k); values (tables, sizes, f, m)."""
    found = values[:, :, :2] @ to_nodes.T
    size = np.abs(found).max(axis=(0, 1))
    matters = (size > _NEGLIGIBLE * size.max(axis=1, keepdims=True)).any(axis=0)
    return np.asarray(found[..., : max(2, int(np.flatnonzero(matters)[-1]) + 1)])


@fast_kernel
def fill_model(begin, block, dt, w, theta, done, heads, coefficients, sign2, out):  # type: ignore[no-untyped-def]
    """f1, f2 at the two Gauss points of blocks of `block` samples from sample `begin` on, out (2, points).

    heads: rows of the next half swings (walk_swings), coefficients (half swings, 2, k) of f1, f2 in them; sign2: what
    f2 turns its sign with, 1 for never or -1 for the direction. Returns the points written so far; `done` were before.
    """
    points = out.shape[1]
    x = np.empty(points)
    even = np.empty(points)
    odd = np.empty(points)
    gauss = 0.5 * math.sqrt((block * block - 1.0) / 3.0)
    for swing in range(coefficients.shape[0]):
        side = heads[swing, HEAD_SIDE]
        second = side if sign2 < 0.0 else 1.0
        n = 0
        while done + n < points:
            k = done + n
            place = begin + (k // 2) * block + 0.5 * (block - 1.0) + (gauss if k % 2 else -gauss)
            x[n] = 2.0 * (w * dt * place + theta - heads[swing, HEAD_START]) / heads[swing, HEAD_DURATION] - 1.0
            if x[n] >= 1.0:
                break
            n += 1
        here = coefficients[swing]
        for i in range(n):
            even[i] = 1.0
            odd[i] = x[i]
            out[0, done + i] = side * (here[0, 0] + here[0, 1] * x[i])
            out[1, done + i] = second * (here[1, 0] + here[1, 1] * x[i])
        for k in range(2, here.shape[1]):
            a = side * here[0, k]
            b = second * here[1, k]
            for i in range(n):
                following = 2.0 * x[i] * odd[i] - even[i]
                even[i] = odd[i]
                odd[i] = following
                out[0, done + i] += a * following
                out[1, done + i] += b * following
        done += n
    return done

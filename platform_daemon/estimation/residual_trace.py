"""The fitted signal at chosen places, from the tables of half swings that a pass over the samples has left behind."""

from __future__ import annotations

import math

import numpy as np

from .jit import fast_kernel, kernel
from .sampling import DIPOLE
from .swing_chain import HEAD_DURATION, HEAD_SIDE, HEAD_START

_NEGLIGIBLE = 1e-6  # of the largest coefficient: far below any noise


@fast_kernel
def _to_coefficients(values, to_nodes, coefficients):  # type: ignore[no-untyped-def]
    """Chebyshev coefficients (k, 2, m) of f1, f2 at all tabulated sizes; returns how many of the m matter."""
    m = to_nodes.shape[0]
    needed = 2
    for size in range(values.shape[0]):
        for row in range(2):
            largest = 0.0
            for k in range(m):
                total = 0.0
                for i in range(m):
                    total += to_nodes[k, i] * values[size, row, i]
                coefficients[size, row, k] = total
                largest = max(largest, abs(total))
            count = m
            while count > needed and abs(coefficients[size, row, count - 1]) < _NEGLIGIBLE * largest:
                count -= 1
            needed = max(needed, count)
    return needed


@fast_kernel
def _interpolate(weights, coefficients, count, sign1, sign2, out):  # type: ignore[no-untyped-def]
    """Coefficients of a half swing between the tabulated sizes, out (2, m)."""
    for k in range(count):
        a = b = 0.0
        for j in range(weights.size):
            a += weights[j] * coefficients[j, 0, k]
            b += weights[j] * coefficients[j, 1, k]
        out[0, k] = sign1 * a
        out[1, k] = sign2 * b


@fast_kernel
def _evaluate(coefficients, count, x, n, out, first):  # type: ignore[no-untyped-def]
    """Sums of Chebyshev polynomials at places x (n,) of a half swing into out (2, ...) from `first` on."""
    even = np.ones(n)
    odd = x[:n].copy()
    for i in range(n):
        out[0, first + i] = coefficients[0, 0] + coefficients[0, 1] * odd[i]
        out[1, first + i] = coefficients[1, 0] + coefficients[1, 1] * odd[i]
    for k in range(2, count):
        a = coefficients[0, k]
        b = coefficients[1, k]
        for i in range(n):
            following = 2.0 * x[i] * odd[i] - even[i]
            even[i] = odd[i]
            odd[i] = following
            out[0, first + i] += a * following
            out[1, first + i] += b * following


@kernel
def fill_model(  # type: ignore[no-untyped-def]
    begin, block, dt, w, theta, done, count, heads, weights, symmetric, observable, to_nodes, values, out
):
    """f1, f2 at the two Gauss points of blocks of `block` samples from sample `begin` on, out (2, points).

    heads, weights: the next `count` half swings as walk_swings leaves them; values (2, k, f, m) of their tables.
    Returns the points written so far; `done` were before.
    """
    coefficients = np.empty((2, values.shape[1], 2, to_nodes.shape[0]))
    needed = _to_coefficients(values[0], to_nodes, coefficients[0])
    if not symmetric:
        needed = max(needed, _to_coefficients(values[1], to_nodes, coefficients[1]))
    here = np.empty((2, to_nodes.shape[0]))
    x = np.empty(out.shape[1])
    gauss = 0.5 * math.sqrt((block * block - 1.0) / 3.0)
    for swing in range(count):
        side = heads[swing, HEAD_SIDE]
        n = 0
        while done + n < out.shape[1]:
            k = done + n
            place = begin + (k // 2) * block + 0.5 * (block - 1.0) + (gauss if k % 2 else -gauss)
            x[n] = 2.0 * (w * dt * place + theta - heads[swing, HEAD_START]) / heads[swing, HEAD_DURATION] - 1.0
            if x[n] >= 1.0:
                break
            n += 1
        if n > 0:
            which = 0 if symmetric or side > 0.0 else 1
            sign2 = 1.0 if observable == DIPOLE else side
            _interpolate(weights[swing], coefficients[which], needed, side, sign2, here)
            _evaluate(here, needed, x, n, out, done)
        done += n
    return done

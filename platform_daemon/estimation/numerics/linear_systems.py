"""Small linear systems, compiled: where a call of LAPACK would cost more than the work."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.thresholds import THRESHOLDS

from .jit import fast_part, kernel

LIMITS = THRESHOLDS.physics
_SINGULAR = LIMITS.singular_pivot


@fast_part
def factorise(matrix, order):  # type: ignore[no-untyped-def]
    """LU factors with row exchanges in place, `order` (m,) the rows; False if singular."""
    m = matrix.shape[0]
    for k in range(m):
        best = k
        largest = abs(matrix[k, k])
        for i in range(k + 1, m):
            if abs(matrix[i, k]) > largest:
                best = i
                largest = abs(matrix[i, k])
        order[k] = best
        if not largest > _SINGULAR:
            return False
        if best != k:
            for j in range(m):
                swap = matrix[k, j]
                matrix[k, j] = matrix[best, j]
                matrix[best, j] = swap
        pivot = 1.0 / matrix[k, k]
        above = matrix[k, k + 1 :]  # slices: their loops run in lanes
        for i in range(k + 1, m):
            factor = matrix[i, k] * pivot
            matrix[i, k] = factor
            row = matrix[i, k + 1 :]
            for j in range(row.size):
                row[j] -= factor * above[j]
    return True


@fast_part
def substitute(matrix, order, x):  # type: ignore[no-untyped-def]
    """Solve with the factors, x (m,) in place."""
    m = matrix.shape[0]
    for k in range(m):
        best = order[k]
        swap = x[k]
        x[k] = x[best]
        x[best] = swap
    for i in range(m):
        total = x[i]
        for j in range(i):
            total -= matrix[i, j] * x[j]
        x[i] = total
    for i in range(m - 1, -1, -1):
        total = x[i]
        for j in range(i + 1, m):
            total -= matrix[i, j] * x[j]
        x[i] = total / matrix[i, i]


@kernel
def solve_scaled(matrix, gradient, free, damping, step):  # type: ignore[no-untyped-def]
    """Step of the free parameters (the others 0), from normal equations whose columns are scaled to unit norm.

    matrix (n, n), gradient (n,), free bool (n,); `damping` is added to the scaled diagonal. Returns the fall of chi^2
    that the quadratic model predicts, NaN if the matrix is singular.
    """
    n = gradient.size
    size = 0
    index = np.empty(n, dtype=np.int64)
    scale = np.zeros(n)
    for p in range(n):
        step[p] = 0.0
        if free[p]:
            index[size] = p
            scale[size] = 1.0 / np.sqrt(max(matrix[p, p], 1e-300))
            size += 1
    scaled = np.empty((size, size))
    x = np.empty(size)
    order = np.empty(size, dtype=np.int64)
    for p in range(size):
        for q in range(size):
            scaled[p, q] = matrix[index[p], index[q]] * scale[p] * scale[q]
        scaled[p, p] += damping
        x[p] = scale[p] * gradient[index[p]]
    if not factorise(scaled, order):
        return np.nan
    substitute(scaled, order, x)
    predicted = 0.0
    for p in range(size):
        step[index[p]] = scale[p] * x[p]
    for p in range(n):
        bent = 0.0
        for q in range(n):
            bent += matrix[p, q] * step[q]
        predicted += step[p] * (2.0 * gradient[p] - bent)
    return predicted

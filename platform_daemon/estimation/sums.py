"""Sums over the samples of a half swing, and over its nodes: the inner loops of moments.py."""

from __future__ import annotations

from .jit import fast_kernel

CHUNK = 384  # samples whose polynomials fit into the fastest cache


@fast_kernel
def spread(y, rows, first, last, x, dx, scratch, sums, ones, energy):  # type: ignore[no-untyped-def]
    """Add samples first .. last-1 of three channels times T_k to sums (3, m), of ones to ones (m,), y^2 to energy (3,).

    x: place of the first sample in [-1, 1], dx the step; scratch (3, CHUNK); m is even.
    """
    y0 = y[rows[0]]
    y1 = y[rows[1]]
    y2 = y[rows[2]]
    twice_x = scratch[0]
    t0 = scratch[1]
    t1 = scratch[2]
    for begin in range(first, last, CHUNK):
        n = min(CHUNK, last - begin)
        e0 = 0.0
        e1 = 0.0
        e2 = 0.0
        for i in range(n):
            place = x + dx * (begin - first + i)
            twice_x[i] = 2.0 * place
            t0[i] = 1.0
            t1[i] = place
            e0 += y0[begin + i] * y0[begin + i]
            e1 += y1[begin + i] * y1[begin + i]
            e2 += y2[begin + i] * y2[begin + i]
        energy[0] += e0
        energy[1] += e1
        energy[2] += e2
        for k in range(0, ones.size, 2):
            a = b = a0 = b0 = a1 = b1 = a2 = b2 = 0.0
            for i in range(n):
                even = t0[i]
                odd = t1[i]
                a += even
                b += odd
                a0 += even * y0[begin + i]
                b0 += odd * y0[begin + i]
                a1 += even * y1[begin + i]
                b1 += odd * y1[begin + i]
                a2 += even * y2[begin + i]
                b2 += odd * y2[begin + i]
                following = twice_x[i] * odd - even
                t0[i] = following
                t1[i] = twice_x[i] * following - odd
            ones[k] += a
            ones[k + 1] += b
            sums[0, k] += a0
            sums[0, k + 1] += b0
            sums[1, k] += a1
            sums[1, k + 1] += b1
            sums[2, k] += a2
            sums[2, k + 1] += b2


@fast_kernel
def to_nodes(matrix, sums, out):  # type: ignore[no-untyped-def]
    """out (rows, m) = sums (rows, m) by T_k, turned into sums against the node polynomials; matrix (k, node)."""
    m = matrix.shape[0]
    for r in range(sums.shape[0]):
        for i in range(m):
            out[r, i] = 0.0
        for k in range(0, m, 4):
            a = sums[r, k]
            b = sums[r, k + 1]
            c = sums[r, k + 2]
            d = sums[r, k + 3]
            for i in range(m):
                out[r, i] += a * matrix[k, i] + b * matrix[k + 1, i] + c * matrix[k + 2, i] + d * matrix[k + 3, i]


@fast_kernel
def add_products(basis, collected, products):  # type: ignore[no-untyped-def]
    """products (channels, b - 1) += basis times collected data (channels, m)."""
    for channel in range(products.shape[0]):
        for j in range(basis.shape[0]):
            total = 0.0
            for i in range(basis.shape[1]):
                total += basis[j, i] * collected[channel, i]
            products[channel, j] += total


@fast_kernel
def add_gram(basis, ones, weighted, gram):  # type: ignore[no-untyped-def]
    """Lower triangle of gram (b, b) += basis functions with each other and with 1 (the last row)."""
    last = basis.shape[0]
    for j in range(last):
        total = 0.0
        for i in range(ones.size):
            weighted[i] = basis[j, i] * ones[i]
            total += weighted[i]
        gram[last, j] += total
        for k in range(j + 1):
            total = 0.0
            for i in range(ones.size):
                total += weighted[i] * basis[k, i]
            gram[j, k] += total

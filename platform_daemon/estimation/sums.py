"""Sums over the samples of a half swing, and over its nodes: the inner loops of moments.py."""

from __future__ import annotations

from .jit import fast_part

_CHUNK = 384  # samples whose polynomials fit into the fastest cache
_LANE = 8  # samples are handled in so many at once; the last few are filled up with zeros
SCRATCH = 7 * _CHUNK
LANES = 144  # nodes, of several half swings, that are summed over at once

# Parts of arrays are taken as slices here: an index that might be negative keeps a loop from running in lanes.


@fast_part
def count_up(buffer):  # type: ignore[no-untyped-def]
    """Write 0, 1, 2 ... into the part of the buffer (SCRATCH,) where `spread` expects them."""
    for i in range(_CHUNK):
        buffer[6 * _CHUNK + i] = i


@fast_part
def _load(source, target):  # type: ignore[no-untyped-def]
    """Copy samples, fill up with zeros; returns the sum of squares."""
    squares = 0.0
    for i in range(source.size):
        value = source[i]
        target[i] = value
        squares += value * value
    for i in range(source.size, target.size):
        target[i] = 0.0
    return squares


@fast_part
def _place(x, dx, n, numbers, twice, even, odd):  # type: ignore[no-untyped-def]
    """2 x, T_0, T_1 at n places x, x + dx, ...; where T_0 and T_1 are 0, all T_k are."""
    for i in range(n):
        place = x + dx * numbers[i]
        twice[i] = 2.0 * place
        even[i] = 1.0
        odd[i] = place
    for i in range(n, even.size):
        twice[i] = 0.0
        even[i] = 0.0
        odd[i] = 0.0


@fast_part
def spread(y, row, first, last, x, dx, buffer, sums, energy):  # type: ignore[no-untyped-def]
    """Add samples first .. last-1 of channels row .. row+2 times T_k to the same rows of sums (.., m), y^2 to energy.

    Ones instead of samples are added to the last row of sums, once (with row 0). A channel that does not exist is
    replaced by the last. x: place of the first sample in [-1, 1], dx the step; buffer (SCRATCH,), counted up; m is
    even.
    """
    ones = sums.shape[0] - 1
    top = y.shape[0] - 1
    for begin in range(first, last, _CHUNK):
        n = min(_CHUNK, last - begin)
        padded = (n + _LANE - 1) // _LANE * _LANE
        _place(
            x + dx * (begin - first), dx, n, buffer[6 * _CHUNK :], buffer[3 * _CHUNK : 3 * _CHUNK + padded],
            buffer[4 * _CHUNK : 4 * _CHUNK + padded], buffer[5 * _CHUNK : 5 * _CHUNK + padded],
        )  # fmt: skip
        for r in range(3):
            at = r * _CHUNK
            energy[row + r] += _load(y[min(row + r, top), begin : begin + n], buffer[at : at + padded])
        for k in range(0, sums.shape[1], 2):
            a = b = a0 = b0 = a1 = b1 = a2 = b2 = 0.0
            for i in range(padded):
                even = buffer[4 * _CHUNK + i]
                odd = buffer[5 * _CHUNK + i]
                a += even
                b += odd
                a0 += even * buffer[i]
                b0 += odd * buffer[i]
                a1 += even * buffer[_CHUNK + i]
                b1 += odd * buffer[_CHUNK + i]
                a2 += even * buffer[2 * _CHUNK + i]
                b2 += odd * buffer[2 * _CHUNK + i]
                following = buffer[3 * _CHUNK + i] * odd - even
                buffer[4 * _CHUNK + i] = following
                buffer[5 * _CHUNK + i] = buffer[3 * _CHUNK + i] * following - odd
            if row == 0:
                sums[ones, k] += a
                sums[ones, k + 1] += b
            sums[row, k] += a0
            sums[row, k + 1] += b0
            sums[row + 1, k] += a1
            sums[row + 1, k + 1] += b1
            sums[row + 2, k] += a2
            sums[row + 2, k + 1] += b2


@fast_part
def to_nodes(matrix, sums, at, out):  # type: ignore[no-untyped-def]
    """sums (rows, m) by T_k, turned into sums against the node polynomials, out[:, at : at + m]; matrix (k, node).

    m is a multiple of four.
    """
    m = matrix.shape[0]
    for r in range(sums.shape[0]):
        target = out[r, at : at + m]
        for i in range(m):
            target[i] = 0.0
        for k in range(0, m, 4):
            a = sums[r, k]
            b = sums[r, k + 1]
            c = sums[r, k + 2]
            d = sums[r, k + 3]
            for i in range(m):
                target[i] += a * matrix[k, i] + b * matrix[k + 1, i] + c * matrix[k + 2, i] + d * matrix[k + 3, i]


@fast_part
def add_products(basis, collected, n, products):  # type: ignore[no-untyped-def]
    """products (channels, b - 1) += basis times collected data (channels, .) at the first n nodes."""
    for channel in range(products.shape[0]):
        for j in range(basis.shape[0]):
            total = 0.0
            for i in range(n):
                total += basis[j, i] * collected[channel, i]
            products[channel, j] += total


@fast_part
def add_gram(basis, ones, n, weighted, gram):  # type: ignore[no-untyped-def]
    """Lower triangle of gram (b, b) += basis functions with each other and with 1 (the last row), at n nodes."""
    last = basis.shape[0]
    for j in range(last):
        total = 0.0
        for i in range(n):
            weighted[i] = basis[j, i] * ones[i]
            total += weighted[i]
        gram[last, j] += total
        for k in range(j + 1):
            total = 0.0
            for i in range(n):
                total += weighted[i] * basis[k, i]
            gram[j, k] += total

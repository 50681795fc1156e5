"""Sums over the samples of a half cycle, and over its nodes: the inner loops of tabulated.py."""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import fast_part
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.least_squares
_CHUNK = LIMITS.kernel_chunk_samples
_LANE = LIMITS.kernel_lane_samples
BATCH = LIMITS.kernel_batch_half_cycles

SCRATCH = 7 * _CHUNK

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
def accumulate_samples(y, row, first, last, x, dx, buffer, sums, ones, energy):  # type: ignore[no-untyped-def]
    """Add samples first .. last-1 of channels row .. row+2 times T_k to three columns of sums (m, ..), y^2 to energy.

    Ones instead of samples are added to column `ones`, once (with row 0); behind it follow those of the channels. A
    channel that does not exist is replaced by the last. x: place of the first sample in [-1, 1], dx the step; buffer
    (SCRATCH,), counted up; m is even.
    """
    at = ones + 1 + row
    top = y.shape[0] - 1
    for begin in range(first, last, _CHUNK):
        n = min(_CHUNK, last - begin)
        padded = (n + _LANE - 1) // _LANE * _LANE
        _place(
            x + dx * (begin - first), dx, n, buffer[6 * _CHUNK :], buffer[3 * _CHUNK : 3 * _CHUNK + padded],
            buffer[4 * _CHUNK : 4 * _CHUNK + padded], buffer[5 * _CHUNK : 5 * _CHUNK + padded],
        )  # fmt: skip
        for r in range(3):
            energy[row + r] += _load(y[min(row + r, top), begin : begin + n], buffer[r * _CHUNK : r * _CHUNK + padded])
        for k in range(0, sums.shape[0], 2):
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
                sums[k, ones] += a
                sums[k + 1, ones] += b
            sums[k, at] += a0
            sums[k + 1, at] += b0
            sums[k, at + 1] += a1
            sums[k + 1, at + 1] += b1
            sums[k, at + 2] += a2
            sums[k + 1, at + 2] += b2


@fast_part
def to_nodes(matrix, sums, lanes, out):  # type: ignore[no-untyped-def]
    """Sums by T_k turned into sums against the node polynomials, out (rows, BATCH m), and set back to zero.

    sums (m, BATCH rows): a half cycle after the other; matrix (k, node); lanes (BATCH rows,) is scratch.
    m is a multiple of four.
    """
    m = matrix.shape[0]
    rows = out.shape[0]
    for node in range(m):
        for i in range(lanes.size):
            lanes[i] = 0.0
        for k in range(0, m, 4):
            a = matrix[k, node]
            b = matrix[k + 1, node]
            c = matrix[k + 2, node]
            d = matrix[k + 3, node]
            for i in range(lanes.size):
                lanes[i] += a * sums[k, i] + b * sums[k + 1, i] + c * sums[k + 2, i] + d * sums[k + 3, i]
        for half_cycle in range(BATCH):
            for r in range(rows):
                out[r, half_cycle * m + node] = lanes[half_cycle * rows + r]
    for k in range(m):
        for i in range(lanes.size):
            sums[k, i] = 0.0


@fast_part
def add_products(basis, collected, n, products):  # type: ignore[no-untyped-def]
    """products (channels, b - 1) += basis times collected data (1 + channels, .) at the first n nodes."""
    for channel in range(products.shape[0]):
        for j in range(basis.shape[0]):
            total = 0.0
            for i in range(n):
                total += basis[j, i] * collected[1 + channel, i]
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

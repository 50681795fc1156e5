"""Moments of the data with the model's basis (basis_functions.py), half cycle by half cycle, without visiting the basis
at the samples.

On a half cycle every basis function is a polynomial with known values at m nodes. Its product with the data is
sum over nodes of B(node) Y(node), where Y collects the samples against the node polynomials: a few multiply-adds per
sample, independent of the number of basis functions. Products of basis functions are collected in the same way from
ones.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.jit import fast_kernel, fast_part
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.physics.trajectory.half_cycle_chain import HEAD, HEAD_DURATION, HEAD_SIDE, HEAD_START
from platform_daemon.estimation.physics.trajectory.half_cycle_table import look_up_values

from .kernels import BATCH, SCRATCH, accumulate_samples, add_gram, add_products, count_up, to_nodes


@fast_part
def write_basis(values, head, observable, nodes, w, theta, columns, at, basis):  # type: ignore[no-untyped-def]
    """Basis functions at the nodes into basis[:, at : at + m] from the values in the mirrored frame."""
    m = nodes.size
    side = head[HEAD_SIDE]
    for k in range(2):
        sign = side if k == 0 or observable != DIPOLE else 1.0
        function = basis[k, at : at + m]
        slope = basis[2 + k, at : at + m]
        by_w = basis[4 + k, at : at + m]
        for i in range(m):
            time = (head[HEAD_START] + 0.5 * head[HEAD_DURATION] * (nodes[i] + 1.0) - theta) / w
            function[i] = sign * values[k, i]
            slope[i] = sign * values[2 + k, i]
            by_w[i] = sign * values[2 + k, i] * time
        for p in range(columns):
            by_size = sign * head[HEAD + p]
            own = sign if p > 0 else 0.0
            shift = sign * head[HEAD + columns + p]
            derivative = basis[6 + 2 * p + k, at : at + m]
            for i in range(m):
                derivative[i] = by_size * values[4 + k, i] + own * values[4 + 2 * p + k, i] - shift * values[2 + k, i]


@fast_kernel
def collect_half_cycles(  # type: ignore[no-untyped-def]
    y, first, last, dt, w, theta, skipped, stride, count, heads, weights, mirrored, observable, nodes, matrix, values,
    gram, products, energy,
):  # fmt: skip
    """Add the moments of samples first .. last-1 in the first `count` half cycles of heads, weights (walk_half_cycles).

    y (channels, n); values (2, k, f, m) the tables of the two directions, of which mirrored motion needs only the
    first; skipped: half cycles passed before these; of all of them every stride-th takes part. nodes (m,), matrix
    (m, m): ChebyshevGrid.nodes, ChebyshevGrid.to_nodes.
    gram (b, b), products (channels, b), energy (channels,) grow. Returns the samples that took part.
    """
    channels = y.shape[0]
    columns = (heads.shape[1] - HEAD) // 2
    m = nodes.size
    b = gram.shape[0]
    groups = (channels + 2) // 3
    rows = 1 + 3 * groups
    here = np.empty((4 + 2 * columns, m))
    basis = np.empty((b - 1, BATCH * m))
    sums = np.zeros((m, BATCH * rows))
    lanes = np.empty(BATCH * rows)
    collected = np.empty((rows, BATCH * m))
    squares = np.zeros(3 * groups)
    scratch = np.empty(SCRATCH)
    count_up(scratch)
    weighted = np.empty(BATCH * m)
    used = 0
    held = np.int64(0)  # in the batch; typed: a literal would compile everything it is passed to twice
    begin = max(first, math.ceil((heads[0, HEAD_START] - theta) / (w * dt)))
    for h in range(count):
        stop = min(last, math.ceil((heads[h + 1, HEAD_START] - theta) / (w * dt)))
        if stop <= begin:
            continue
        if (skipped + h) % stride == 0:
            if held == BATCH:
                to_nodes(matrix, sums, lanes, collected)
                add_products(basis, collected, held * m, products)
                add_gram(basis, collected[0], held * m, weighted, gram)
                held = np.int64(0)
            dx = 2.0 * w * dt / heads[h, HEAD_DURATION]
            x = 2.0 * (w * begin * dt + theta - heads[h, HEAD_START]) / heads[h, HEAD_DURATION] - 1.0
            for group in range(groups):
                accumulate_samples(y, 3 * group, begin, stop, x, dx, scratch, sums, held * rows, squares)
            look_up_values(weights[h], values[0 if mirrored or heads[h, HEAD_SIDE] > 0.0 else 1], here)
            write_basis(here, heads[h], observable, nodes, w, theta, columns, held * m, basis)
            for channel in range(channels):
                products[channel, b - 1] += sums[0, held * rows + 1 + channel]
            held += 1
            gram[b - 1, b - 1] += stop - begin
            used += stop - begin
        begin = stop
    to_nodes(matrix, sums, lanes, collected)
    add_products(basis, collected, held * m, products)
    add_gram(basis, collected[0], held * m, weighted, gram)
    for j in range(b):
        for k in range(j):
            gram[k, j] = gram[j, k]
    for channel in range(channels):
        energy[channel] += squares[channel]
    return used

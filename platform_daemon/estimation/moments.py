"""Moments of the data with the model's basis (sampling.py), half swing by half swing, without visiting the basis at
the samples.

On a half swing every basis function is a polynomial with known values at m nodes. Its product with the data is
sum over nodes of B(node) Y(node), where Y collects the samples against the node polynomials: a few multiply-adds per
sample, whatever the number of basis functions. Products of basis functions are collected in the same way from ones.
"""

from __future__ import annotations

import math

import numpy as np

from .half_swing import direction_at_rest
from .jit import fast_kernel, kernel
from .sampling import DIPOLE
from .sums import CHUNK, add_gram, add_products, spread
from .sums import to_nodes as sums_to_nodes
from .swing_table import build_table, look_up_end, look_up_values
from .terms.dispatch import acceleration
from .trace import STATUS_LOST, STATUS_OK, STATUS_STUCK

BAND_RATIO = 4.5
_MARGIN = 1.15
_WIDEST = 3.0  # rad; close to the inverted position a half swing takes forever


@fast_kernel
def _write_basis(values, side, observable, start, duration, nodes, w, theta, slope_size, slope_start, columns, basis):  # type: ignore[no-untyped-def]
    """Basis functions at the nodes, (n_basis - 1, m), from the values in the mirrored frame."""
    m = nodes.size
    sign2 = 1.0 if observable == DIPOLE else side
    for i in range(m):
        time = (start + 0.5 * duration * (nodes[i] + 1.0) - theta) / w
        basis[0, i] = side * values[0, i]
        basis[1, i] = sign2 * values[1, i]
        slope1 = side * values[2, i]
        slope2 = sign2 * values[3, i]
        basis[2, i] = slope1
        basis[3, i] = slope2
        basis[4, i] = slope1 * time
        basis[5, i] = slope2 * time
    for p in range(columns):
        by_size1 = side * slope_size[p]
        by_size2 = sign2 * slope_size[p]
        own1 = side if p > 0 else 0.0
        own2 = sign2 if p > 0 else 0.0
        shift = slope_start[p]
        for i in range(m):
            basis[6 + 2 * p, i] = by_size1 * values[4, i] + own1 * values[4 + 2 * p, i] - shift * basis[2, i]
            basis[7 + 2 * p, i] = by_size2 * values[5, i] + own2 * values[5 + 2 * p, i] - shift * basis[3, i]


@kernel
def _add_rest(y, first, last, amplitude, slope_size, sign, observable, columns, gram, products, energy):  # type: ignore[no-untyped-def]
    """Samples first .. last-1 of a rotor stuck at `amplitude`: dm/dt is silent, an angle is constant."""
    b = gram.shape[0]
    constant = np.zeros(b)
    constant[b - 1] = 1.0
    if observable != DIPOLE:
        constant[0] = amplitude
        for p in range(columns):
            constant[6 + 2 * p] = sign * slope_size[p]
    for j in range(b):
        for k in range(j + 1):
            gram[j, k] += (last - first) * constant[j] * constant[k]
    for channel in range(y.shape[0]):
        total = 0.0
        for i in range(first, last):
            total += y[channel, i]
            energy[channel] += y[channel, i] * y[channel, i]
        for j in range(b):
            products[channel, j] += total * constant[j]


@kernel
def _band(size, left, side, codes, widths, c):  # type: ignore[no-untyped-def]
    """Sizes (low, high) of the half swings in the remaining `left`, from the work of the losses in one of them.

    An estimate: a ring-down that leaves the band gets another table.
    """
    grad = np.zeros(c.size + 1)
    points = 8
    work = 0.0
    for k in range(points):
        place = math.pi * (k + 0.5) / points
        phi = -size * math.cos(place)
        v = math.sqrt(2.0 * (math.cos(phi) - math.cos(size)))
        there, _, _ = acceleration(side * phi, side * v, side, codes, widths, c, grad)
        back, _, _ = acceleration(side * phi, -side * v, -side, codes, widths, c, grad)
        # What changes sign with the motion is not conservative.
        work += 0.5 * side * (there - back) * math.sin(place) * size * math.pi / points
    change = _MARGIN * (left / math.pi + 2.0) * work / max(math.sin(size), 0.1)
    low = max(size / BAND_RATIO, size + min(change, 0.0) - 1e-3 * size)
    high = min(1.5 * size, size + max(change, 0.0) + 1e-3 * size)
    return low, high


@kernel
def collect_moments(  # type: ignore[no-untyped-def]
    y, first, last, dt, w, theta, amplitude, columns, codes, widths, c, symmetric, observable, stride,
    nodes, to_nodes, once, twice, barycentric, sizes, accelerations, values, ends, gram, products, energy, slopes,
):  # fmt: skip
    """Moments of samples first .. last-1 with the trajectory from the turning point (amplitude, s = 0).

    y (channels, n); sizes (2, k), accelerations (2, k, m), values (2, k, f, m), ends (2, k, 2 + 2 columns) are the
    tables of the two directions (one only if the torque is symmetric), kept between calls as first guesses; with k = 1
    every half swing is solved for itself.
    stride: every stride-th half swing is used; odd, so that both directions are seen.
    gram (b, b), products (channels, b), energy (channels,) are set, and slopes (columns,): d start/d (size, c) of the
    last half swing. Returns (status, samples used).
    """
    channels = y.shape[0]
    m = nodes.size
    b = gram.shape[0]
    grad = np.zeros(c.size + 1)
    slope_size = np.zeros(columns)
    slope_start = np.zeros(columns)
    low = np.zeros(2)
    high = np.zeros(2)
    weights = np.empty(sizes.shape[1])
    end = np.empty(2 + 2 * columns)
    here = np.empty((4 + 2 * columns, m))
    flat = here.reshape(here.size)
    flat_values = values.reshape(2, values.shape[1], here.size)
    basis = np.empty((b - 1, m))
    groups = (channels + 2) // 3
    sums = np.empty((3 * groups + 1, m))
    collected = np.empty((3 * groups + 1, m))
    squares = np.zeros(3 * groups)
    scratch = np.empty((3, CHUNK))
    rows = np.empty(3, dtype=np.int64)
    weighted = np.empty(m)
    gram.fill(0.0)
    products.fill(0.0)
    energy.fill(0.0)
    size = abs(amplitude)
    slope_size[0] = 1.0 if amplitude > 0.0 else -1.0
    start = 0.0
    carry = 0.0  # compensated sum: the start times are what the phase accuracy of 1e-9 rests on
    s_end = w * (last - 1) * dt + theta
    begin = first
    used = 0
    status = STATUS_LOST
    most = int(s_end / 2.0) + 16
    for h in range(most):
        if start > s_end or begin >= last:
            status = STATUS_OK
            break
        at = amplitude
        side, _ = direction_at_rest(at, 0.0, codes, widths, c, grad)
        if side == 0.0:
            sign = 1.0 if at > 0.0 else -1.0
            _add_rest(y, begin, last, at, slope_size, sign, observable, columns, gram, products, energy)
            used += last - begin
            status = STATUS_STUCK
            break
        if side * at >= 0.0 or not size < _WIDEST:
            break
        which = 0 if symmetric or side > 0.0 else 1
        if not low[which] <= size <= high[which]:
            low[which] = high[which] = size
            if sizes.shape[1] > 1:
                low[which], high[which] = _band(size, s_end - start, side, codes, widths, c)
            if not build_table(
                low[which], high[which], 1.0 if symmetric else side, columns, codes, widths, c, observable,
                nodes, once, twice, sizes[which], accelerations[which], values[which], ends[which],
            ):  # fmt: skip
                break
        look_up_end(size, sizes[which], barycentric, ends[which], weights, end)
        duration = end[0]
        stop = min(last, math.ceil((start + duration - theta) / (w * dt)))
        if stop > begin and h % stride == 0:
            used += stop - begin
            sums.fill(0.0)
            x = 2.0 * (w * begin * dt + theta - start) / duration - 1.0
            dx = 2.0 * w * dt / duration
            for group in range(groups):
                for r in range(3):
                    rows[r] = min(3 * group + r, channels - 1)
                sums[3 * groups].fill(0.0)
                spread(
                    y, rows, begin, stop, x, dx, scratch, sums[3 * group : 3 * group + 3], sums[3 * groups],
                    squares[3 * group : 3 * group + 3],
                )  # fmt: skip
            sums_to_nodes(to_nodes, sums, collected)
            look_up_values(weights, flat_values[which], flat)
            _write_basis(
                here, side, observable, start, duration, nodes, w, theta, slope_size, slope_start, columns, basis
            )
            add_products(basis, collected[:channels], products)
            for channel in range(channels):
                products[channel, b - 1] += sums[channel, 0]
            add_gram(basis, collected[3 * groups], weighted, gram)
            gram[b - 1, b - 1] += stop - begin
        begin = max(begin, stop)
        for p in range(columns):
            slope_start[p] += end[2 + columns] * slope_size[p]
            slope_size[p] *= end[2]
            if p > 0:
                slope_start[p] += end[2 + columns + p]
                slope_size[p] += end[2 + p]
        size = end[1]
        amplitude = side * size
        term = duration - carry
        total = start + term
        carry = (total - start) - term
        start = total
    for p in range(columns):
        slopes[p] = slope_start[p]
    for channel in range(channels):
        energy[channel] += squares[channel]
    for j in range(b):
        for k in range(j):
            gram[k, j] = gram[j, k]
    return status, used

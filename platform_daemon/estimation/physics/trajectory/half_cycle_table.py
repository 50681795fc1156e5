"""Half cycles tabulated over their amplitude: between two turning points one number, the size, tells everything.

While the torque depends on phi, v and the direction only, every half cycle of a ring-down is a member of one smooth
family. It is solved at a few Chebyshev sizes of a band and interpolated between them.

Values of a half cycle, float64 (4 + 2 columns, m): f1, f2, their slopes by s, then (d f1/dq, d f2/dq) by size and c at
fixed time, all in the mirrored frame (collocation.py). DIPOLE: f1 = v cos(phi), f2 = -v sin(phi); STATE: phi, v.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.jit import fast_kernel, fast_part
from platform_daemon.estimation.physics.torques.dispatch import acceleration
from platform_daemon.estimation.thresholds import THRESHOLDS

from .basis_functions import DIPOLE
from .collocation import solve_half_cycle
from .table_range import WALK_ANGLE, next_band

LIMITS = THRESHOLDS.physics
_FOURIER_TERMS = LIMITS.first_guess_terms
_MEAN_ROUNDS = LIMITS.first_guess_rounds
_PARABOLA = LIMITS.first_guess_parabola
_ALIKE_LOW = LIMITS.alike_low
_ALIKE_HIGH = LIMITS.alike_high
_SETTLED_SHARE = LIMITS.settled_digits_share


@fast_part
def _write_values(a, phi, v, slopes, columns, observable, out):  # type: ignore[no-untyped-def]
    """Observed functions and their derivatives at the nodes, out (4 + 2 columns, m)."""
    for i in range(a.size):
        if observable == DIPOLE:
            sine = math.sin(phi[i])
            cosine = math.cos(phi[i])
            out[0, i] = v[i] * cosine
            out[1, i] = -v[i] * sine
            out[2, i] = a[i] * cosine - v[i] * v[i] * sine
            out[3, i] = -a[i] * sine - v[i] * v[i] * cosine
            for q in range(columns):
                d_phi = slopes[q, 1, i]
                d_v = slopes[q, 2, i]
                out[4 + 2 * q, i] = -v[i] * sine * d_phi + cosine * d_v
                out[5 + 2 * q, i] = -v[i] * cosine * d_phi - sine * d_v
        else:
            out[0, i] = phi[i]
            out[1, i] = v[i]
            out[2, i] = v[i]
            out[3, i] = a[i]
            for q in range(columns):
                out[4 + 2 * q, i] = slopes[q, 1, i]
                out[5 + 2 * q, i] = slopes[q, 2, i]


@fast_part
def _mean(a, b):  # type: ignore[no-untyped-def]
    """Arithmetic-geometric mean of two positive numbers."""
    for _ in range(_MEAN_ROUNDS):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return a


@fast_part
def undamped(size, nodes, a):  # type: ignore[no-untyped-def]
    """First guess: acceleration a (m,) of the undamped half cycle, from its Fourier series; returns its duration.

    phi = -8 sum over odd n of (-1)^((n-1)/2) q^(n/2) / (n (1 + q^n)) cos(n pi x), with the nome q, x from 0 to 1.
    """
    mean = _mean(1.0, math.cos(0.5 * size))
    nome = math.exp(-math.pi * mean / _mean(1.0, math.sin(0.5 * size)))
    for i in range(a.size):
        a[i] = 0.0
    share = 8.0 * mean * mean
    for n in range(1, _FOURIER_TERMS, 2):
        power = nome ** (0.5 * n)
        for i in range(a.size):
            a[i] += share * n * power / (1.0 + power * power) * math.cos(0.5 * math.pi * n * (nodes[i] + 1.0))
        share = -share
    return math.pi / mean


@fast_part
def _continued(size, k, sizes, ends, accelerations, a):  # type: ignore[no-untyped-def]
    """First guess: acceleration over size, a parabola through those of the three sizes solved before `k`, and so the
    duration, which is returned; a (m,).
    """
    duration = 0.0
    for i in range(a.size):
        a[i] = 0.0
    for j in range(max(0, k - _PARABOLA), k):
        share = 1.0
        for other in range(max(0, k - _PARABOLA), k):
            if other != j:
                share *= (size - sizes[other]) / (sizes[j] - sizes[other])
        duration += share * ends[j, 0]
        for i in range(a.size):
            a[i] += share * (size / sizes[j]) * accelerations[j, i]
    return duration


@fast_part
def _first_guess(size, k, alike, sizes, ends, accelerations, nodes, a):  # type: ignore[no-untyped-def]
    """First guess of the k-th half cycle: from an earlier table that is alike, from its neighbours, or undamped.

    a (m,): its acceleration in that table, if there was one; returns the duration.
    """
    duration = ends[k, 0]
    if alike and duration > 0.0 and _ALIKE_LOW * sizes[k] < size < _ALIKE_HIGH * sizes[k]:
        for i in range(a.size):
            a[i] *= size / sizes[k]
        return duration
    if k > 0 and size > _ALIKE_LOW * sizes[k - 1]:
        return _continued(size, k, sizes, ends, accelerations, a)
    return undamped(size, nodes, a)


@fast_kernel
def build_table(  # type: ignore[no-untyped-def]
    walk, s_end, columns, codes, widths, c, mirrored, observable, digits, nodes, once, twice, bands, all_sizes,
    all_accelerations, all_values, all_ends,
):  # fmt: skip
    """Solve the half cycles at the Chebyshev sizes of the next band of `walk`, to so many digits.

    By direction, of which mirrored motion needs the first only: bands (2, 3), smallest size, largest, and the smallest
    pull back from rest over the largest of all sizes (0 or less: somewhere it sticks), NaN if one has no solution;
    sizes (2, .), values (2, ., 4 + 2 columns, m), ends (2, ., 2 + 2 columns) are written. accelerations (2, ., m) and
    ends hold an earlier solution or zeros when the call begins: solutions nearby are the best first guess. Returns how
    many sizes are used.
    """
    low, high, count = next_band(walk, s_end, codes, widths, c, digits)
    which = 0 if mirrored or walk[WALK_ANGLE] < 0.0 else 1
    side = 1.0 if which == 0 else -1.0
    settled = 10.0 ** (-_SETTLED_SHARE * digits)
    sizes = all_sizes[which, :count]
    accelerations = all_accelerations[which, :count]
    values = all_values[which, :count]
    ends = all_ends[which, :count]
    # Tables of as many sizes are alike; a size that was not used is 0.
    alike = sizes[count - 1] > 0.0 and (count == all_sizes.shape[1] or all_sizes[which, count] == 0.0)
    for k in range(count, all_sizes.shape[1]):
        all_sizes[which, k] = 0.0
    bands[which, 0] = low
    bands[which, 1] = 0.0  # a table that could not be made knows no size
    bands[which, 2] = np.nan
    m = nodes.size
    grad = np.zeros(c.size + 1)
    weakest = np.inf
    strongest = 0.0
    phi = np.empty(m)
    v = np.empty(m)
    slopes = np.empty((columns, 3, m))
    for k in range(count):
        size = 0.5 * (low + high) + 0.5 * (high - low) * math.cos(math.pi * (2 * k + 1) / (2 * count))
        a = accelerations[k]
        duration = _first_guess(size, k, alike, sizes, ends, accelerations, nodes, a)
        sizes[k] = size
        if not solve_half_cycle(
            size, side, duration, settled, columns, codes, widths, c, once, twice, a, phi, v, slopes, ends[k]
        ):
            duration = undamped(size, nodes, a)
            if not solve_half_cycle(
                size, side, duration, settled, columns, codes, widths, c, once, twice, a, phi, v, slopes, ends[k]
            ):
                ends[k, 0] = 0.0
                return count
        _write_values(a, phi, v, slopes, columns, observable, values[k])
        pull, _, _ = acceleration(-side * size, 0.0, side, codes, widths, c, grad)
        weakest = min(weakest, side * pull)
        strongest = max(strongest, side * pull)
    bands[which, 1] = high
    bands[which, 2] = weakest / strongest if strongest > 0.0 else 0.0
    return count


@fast_part
def _weights(size, sizes, barycentric, weights):  # type: ignore[no-untyped-def]
    """Weights (k,) with which the values at the sizes add up to the value at `size`."""
    count = sizes.size
    total = 0.0
    for k in range(count):
        distance = size - sizes[k]
        if distance == 0.0:
            for j in range(count):
                weights[j] = 0.0
            weights[k] = 1.0
            return
        weights[k] = barycentric[k] / distance
        total += weights[k]
    share = 1.0 / total
    for k in range(count):
        weights[k] *= share


@fast_part
def look_up_end(size, sizes, barycentric, ends, weights, end):  # type: ignore[no-untyped-def]
    """Interpolation weights (k,) for `size`, and the end values (2 + 2 columns,) there."""
    _weights(size, sizes, barycentric, weights)
    for j in range(end.size):
        end[j] = 0.0
    for k in range(sizes.size):
        for j in range(end.size):
            end[j] += weights[k] * ends[k, j]


@fast_part
def look_up_values(weights, values, out):  # type: ignore[no-untyped-def]
    """Values out (4 + 2 columns, m) with the weights (k,) of look_up_end; values (k or more, 4 + 2 columns, m)."""
    count = weights.size
    to = out.reshape(out.size)
    table = values[:count].reshape(count, out.size)
    for i in range(to.size):
        to[i] = weights[0] * table[0, i]
    for k in range(1, count - 1, 2):
        for i in range(to.size):
            to[i] += weights[k] * table[k, i] + weights[k + 1] * table[k + 1, i]
    if count % 2 == 0:
        for i in range(to.size):
            to[i] += weights[count - 1] * table[count - 1, i]

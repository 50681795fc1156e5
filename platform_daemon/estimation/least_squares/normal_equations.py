"""Normal equations from moments, compiled: the fit calls this once a pass, and arrays of twelve are all overhead."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.numerics.jit import fast_part, kernel


@fast_part
def coefficients(chain, gains, by_w, by_own, offsets, channel, values, jacobian):  # type: ignore[no-untyped-def]
    """Coefficients of a channel in the basis, values (b,), and their derivatives, jacobian (b, size)."""
    dynamic = chain.shape[0]
    b = values.size
    for j in range(b):
        values[j] = 0.0
        for p in range(jacobian.shape[1]):
            jacobian[j, p] = 0.0
    values[0] = gains[channel, 0]
    values[1] = gains[channel, 1]
    values[b - 1] = offsets[channel]
    for p in range(dynamic):
        for q in range(dynamic):
            jacobian[2 + 2 * p, q] = gains[channel, 0] * chain[p, q]
            jacobian[3 + 2 * p, q] = gains[channel, 1] * chain[p, q]
    for f in range(2):
        jacobian[f, 1] += by_w[channel, f]
        for k in range(by_own.shape[0]):
            jacobian[f, dynamic + k] = by_own[k, channel, f]
    jacobian[b - 1, dynamic + by_own.shape[0] + channel] = 1.0


@kernel
def assemble_normal_equations(  # type: ignore[no-untyped-def]
    chain, gains, by_w, by_own, offsets, gram, products, energy, weights, step, gradient, matrix, squares
):
    """Gradient (size,) and Gauss-Newton matrix (size, size) of half chi^2 with the channels' weights, added to zeros,
    and the sum of squared residuals by channel, squares (channels,), once the linear model has taken a step (size,).
    """
    b = gram.shape[0]
    size = gradient.size
    values = np.empty(b)
    jacobian = np.empty((b, size))
    turned = np.empty((b, size))
    for channel in range(weights.size):
        coefficients(chain, gains, by_w, by_own, offsets, channel, values, jacobian)
        for j in range(b):
            for p in range(size):
                turned[j, p] = 0.0
                values[j] += jacobian[j, p] * step[p]
        left = energy[channel]
        for j in range(b):
            explained = 0.0
            for k in range(b):
                explained += gram[j, k] * values[k]
                for p in range(size):
                    turned[j, p] += gram[j, k] * jacobian[k, p]
            left -= values[j] * (2.0 * products[channel, j] - explained)
            rest = products[channel, j] - explained
            for p in range(size):
                gradient[p] += weights[channel] * jacobian[j, p] * rest
        # Rounding can make the squares of a noise-free record negative.
        squares[channel] = max(left, 0.0)
        for j in range(b):
            for p in range(size):
                if jacobian[j, p] != 0.0:
                    factor = weights[channel] * jacobian[j, p]
                    for q in range(size):
                        matrix[p, q] += factor * turned[j, q]


@kernel
def dipole_gains(mixed, w, m_r, gains, by_w, by_own):  # type: ignore[no-untyped-def]
    """Gains of f1 and f2 for a dipole m_r w, and their derivatives by w, m_r and a rotation vector delta.

    mixed (channels, 3): channels by (u, v, w). R [delta]x has the columns v (-d_w, 0, d_u) and u (0, d_w, -d_v).
    """
    for channel in range(mixed.shape[0]):
        u = mixed[channel, 0]
        v = mixed[channel, 1]
        across = mixed[channel, 2]
        gains[channel, 0] = w * m_r * v
        gains[channel, 1] = w * m_r * u
        by_w[channel, 0] = m_r * v
        by_w[channel, 1] = m_r * u
        by_own[0, channel, 0] = w * v
        by_own[0, channel, 1] = w * u
        by_own[1, channel, 0] = w * m_r * across
        by_own[1, channel, 1] = 0.0
        by_own[2, channel, 0] = 0.0
        by_own[2, channel, 1] = -w * m_r * across
        by_own[3, channel, 0] = -w * m_r * u
        by_own[3, channel, 1] = w * m_r * v

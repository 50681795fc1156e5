"""One step of the explicit Runge-Kutta method of order 8(5,3) of Hairer, Norsett and Wanner (DOP853) with dense output.

The method is explicit because the friction of the contact is stiff only while the spin reverses, where the error
estimate shortens the steps.  The tables are those of scipy.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from sim_backend.rotor.kernel import kernel

from .acceleration import OMEGA, STATES, Q, rates

STAGES, EXTRA, ROWS = 12, 3, 7
FIRST, LAST = 13, 16  # rows of k for the extra stages of the dense output; row 12 is the rate at the end
A = np.zeros((LAST, LAST))
A[:STAGES, :STAGES] = DOP853.A
A[FIRST:, :] = DOP853.A_EXTRA
B = np.array(DOP853.B)
C = np.concatenate([DOP853.C, [1.0], DOP853.C_EXTRA])
E3, E5, D = np.array(DOP853.E3), np.array(DOP853.E5), np.array(DOP853.D)


@kernel
def _stage(row, tau, h, y, p, terms, k, work):  # type: ignore[no-untyped-def]
    """Write the rates at stage `row` into that row of k (LAST, STATES)."""
    for i in range(STATES):
        work[i] = y[i]
    for j in range(row):
        weight = h * A[row, j]
        if weight != 0.0:
            for i in range(STATES):
                work[i] += weight * k[j, i]
    rates(tau + C[row] * h, work, p, terms, k[row])


@kernel
def attempt(tau, h, y, p, terms, scale, k, work, end):  # type: ignore[no-untyped-def]
    """Write a step of length h from y into end (STATES,); return its error relative to the tolerance.

    k: (LAST, STATES), row 0 holds the rates at y; scale: (STATES,) tolerance of each component; work: (STATES,).
    """
    for row in range(1, STAGES):
        _stage(row, tau, h, y, p, terms, k, work)
    low, high = work, k[STAGES]  # both are free here
    for i in range(STATES):
        end[i] = y[i]
        low[i] = 0.0
        high[i] = 0.0
    for j in range(STAGES):
        if B[j] != 0.0:
            for i in range(STATES):
                end[i] += h * B[j] * k[j, i]
                low[i] += E3[j] * k[j, i]
                high[i] += E5[j] * k[j, i]
    three = 0.0
    five = 0.0
    for i in range(STATES):
        three += (low[i] / scale[i]) ** 2
        five += (high[i] / scale[i]) ** 2
    if five == 0.0 and three == 0.0:
        return 0.0
    return h * five / sqrt((five + 0.01 * three) * STATES)


@kernel
def prepare_dense(tau, h, y, end, p, terms, k, work, dense):  # type: ignore[no-untyped-def]
    """Write the coefficients of the polynomial between y and end for `orientation_at` into dense (ROWS, STATES).

    Row 12 of k contains the rates at the end.
    """
    for row in range(FIRST, LAST):
        _stage(row, tau, h, y, p, terms, k, work)
    for i in range(Q, STATES):
        change = end[i] - y[i]
        dense[0, i] = change
        dense[1, i] = h * k[0, i] - change
        dense[2, i] = 2.0 * change - h * (k[12, i] + k[0, i])
    for row in range(ROWS - 3):
        for i in range(Q, STATES):
            dense[3 + row, i] = 0.0
        for j in range(LAST):
            weight = h * D[row, j]
            if weight != 0.0:
                for i in range(Q, STATES):
                    dense[3 + row, i] += weight * k[j, i]


@kernel
def orientation_at(x: float, y: NDArray[np.float64], dense: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Write quaternion and angular velocity at the fraction x of the step into their places of out (STATES,)."""
    for i in range(Q, STATES):
        total = 0.0
        for row in range(ROWS - 1, -1, -1):
            total += dense[row, i]
            total *= x if (ROWS - 1 - row) % 2 == 0 else 1.0 - x
        out[i] = y[i] + total
    size = sqrt(out[Q] ** 2 + out[Q + 1] ** 2 + out[Q + 2] ** 2 + out[Q + 3] ** 2)
    for i in range(Q, OMEGA):
        out[i] /= size

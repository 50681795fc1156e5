"""One step of Gauss-Legendre collocation for phi'' = a(t, phi, phi'), and the polynomials that it uses.

Inside a step the acceleration is a polynomial of degree 7 through the 8 Gauss nodes; velocity and angle are its exact
integrals.  The end of the step is accurate to order 16, the polynomial inside to order 8 of (omega h), so with
omega h = 0.3 a step covers about 13 samples of the ADC at rounding-error accuracy, and any instant inside it can be
evaluated afterwards.  Polynomials are written in x = -1 ... 1 across the step.
"""

from __future__ import annotations

from math import cos

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from .internal_state import rates
from .kernel import kernel
from .pieces import NODES
from .torque import drive, friction

MAX_ITERATIONS = 40
LARGEST = 1e200  # rad/s^2: the iteration diverges
ROUNDING = 1e-14  # of the stiffness: below it the acceleration is rounding noise (drive against friction at rest)


def _lagrange_in_legendre(x: NDArray[np.float64], w: NDArray[np.float64]) -> NDArray[np.float64]:
    """Legendre coefficients (NODES, NODES) of the Lagrange polynomials; column j belongs to node j."""
    order = np.arange(NODES)
    return (2 * order[:, None] + 1) / 2 * w[None, :] * legendre.legvander(x, NODES - 1).T


def _tables() -> tuple[NDArray[np.float64], ...]:
    """Nodes on 0..1, single and double integrals of the Lagrange polynomials up to each node and to the end, and the
    matrix from nodal values to coefficients of powers of x."""
    x, w = legendre.leggauss(NODES)
    basis = _lagrange_in_legendre(x, w)
    ends = np.append((x + 1) / 2, 1.0)
    single, double = np.zeros((NODES + 1, NODES)), np.zeros((NODES + 1, NODES))
    for i, c in enumerate(ends):
        s, weight = c * (x + 1) / 2, c * w / 2
        values = legendre.legvander(2 * s - 1, NODES - 1) @ basis
        single[i], double[i] = weight @ values, (weight * (c - s)) @ values
    powers = np.array([np.pad(p := legendre.leg2poly(np.eye(NODES)[k]), (0, NODES - p.size)) for k in range(NODES)])
    return ends[:-1], single, double, powers.T @ basis


C, A, AA, TO_POWERS = _tables()

# Rows of a step's internal state: its rates at the nodes, its value at the start, and its value at the node that was
# computed last, at last the end.
INTERNAL_START, INTERNAL_NOW, INTERNAL_ROWS = NODES, NODES + 1, NODES + 2


@kernel
def advance(node: int, h: float, internal_state: NDArray[np.float64]) -> None:
    """Write the internal state at a node (NODES: the end) into row INTERNAL_NOW, from its start and rates."""
    for k in range(internal_state.shape[1]):
        total = 0.0
        for j in range(NODES):
            total += A[node, j] * internal_state[j, k]
        internal_state[INTERNAL_NOW, k] = internal_state[INTERNAL_START, k] + h * total


@kernel
def solve_step(
    tau: float,
    h: float,
    phi: float,
    phi_dot: float,
    sign: float,
    q: NDArray[np.float64],
    terms: NDArray[np.float64],
    angle: NDArray[np.float64],
    speed: NDArray[np.float64],
    accel: NDArray[np.float64],
    internal_state: NDArray[np.float64],
) -> tuple[bool, float, float]:
    """Solve one step of length `h` with friction against a motion of direction `sign`, by fixed-point iteration.

    tau: start of the step on the time axis of the field terms, s; h: length, s; phi, phi_dot: angle and speed at the
    start; q: see `torque.parameters`; terms: see `torque.field`.  The function fills angle, speed and accel (NODES,) at
    the nodes; `accel` contains the first guess.  internal_state: (INTERNAL_ROWS, states), see INTERNAL_START.  Returns
    whether the iteration converged, and the angle and speed at the end.
    """
    z = internal_state[INTERNAL_NOW]
    last = np.inf
    done = False
    for _ in range(MAX_ITERATIONS):
        change = 0.0
        size = 0.0
        for i in range(NODES):
            first = 0.0
            second = 0.0
            for j in range(NODES):
                first += A[i, j] * accel[j]
                second += AA[i, j] * accel[j]
            speed[i] = phi_dot + h * first
            angle[i] = phi + h * (C[i] * phi_dot + h * second)
            if z.size > 0:
                advance(i, h, internal_state)
                rates(angle[i], speed[i], cos(angle[i]), sign, z, q, internal_state[i])
            push = drive(tau + C[i] * h, angle[i], speed[i], q, terms, z)
            new = push - sign * friction(tau + C[i] * h, angle[i], sign * speed[i], q)
            change = max(change, abs(new - accel[i]))
            size = max(size, abs(new))
            accel[i] = new
        if not size < LARGEST:
            break
        if change <= 3e-16 * size or (change >= 0.5 * last and change <= 1e-13 * size + ROUNDING * q[1]):
            done = True
            break
        last = change
    if z.size > 0:
        advance(NODES, h, internal_state)
    first = 0.0
    second = 0.0
    for j in range(NODES):
        first += A[NODES, j] * accel[j]
        second += AA[NODES, j] * accel[j]
    return done, phi + h * (phi_dot + h * second), phi_dot + h * first


@kernel
def to_powers(nodal: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Coefficients of 1, x, ... x^7 of the polynomial through the nodal values; both (NODES,)."""
    for k in range(NODES):
        total = 0.0
        for j in range(NODES):
            total += TO_POWERS[k, j] * nodal[j]
        out[k] = total

"""A rotor at rest: where it hangs, and, held by dry friction, when it breaks loose and what its hidden state does."""

from __future__ import annotations

from math import cos

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from drivers.errors import ConfigError

from .collocation import HIDDEN_NOW, HIDDEN_START, MAX_ITERATIONS, NODES, advance
from .hidden import rates, relaxed
from .kernel import kernel
from .torque import drive, friction

NOISE = 1e-13  # of the stiffness: accelerations below it are rounding
STICK_SCAN_S = 2e-5
SETTLED = 1e-15
FARTHEST_RAD = 1.5


@kernel
def _relax(h: float, phi: float, q: NDArray[np.float64], hidden: NDArray[np.float64]) -> None:
    """One step of the hidden state by collocation, the rotor held at phi; the end is in row HIDDEN_NOW."""
    z = hidden[HIDDEN_NOW]
    new = np.zeros(z.size)
    for _ in range(MAX_ITERATIONS):
        done = True
        for i in range(NODES):
            advance(i, h, hidden)
            rates(phi, 0.0, cos(phi), 0.0, z, q, new)
            for k in range(z.size):
                done = done and abs(new[k] - hidden[i, k]) <= SETTLED * abs(new[k])
                hidden[i, k] = new[k]
        if done:
            break
    advance(NODES, h, hidden)


@kernel
def _push(start, at, phi, q, terms, hidden):  # type: ignore[no-untyped-def]
    """|drive| at a time, with the hidden state moved there from `start`."""
    if hidden.shape[1] > 0:
        _relax(at - start, phi, q, hidden)
    return abs(drive(at, phi, 0.0, q, terms, hidden[HIDDEN_NOW]))


@kernel
def release_s(tau, end, phi, q, terms, hidden):  # type: ignore[no-untyped-def]
    """When a rotor at rest breaks loose: first time at which |drive| exceeds static friction; `end` if it does not.

    The hidden state, (HIDDEN_ROWS, states), is taken along.
    """
    hold = friction(phi, 0.0, q) + NOISE * q[1]
    if terms.shape[0] == 0 and hidden.shape[1] == 0:
        return end
    start = tau
    while start < end:
        high = min(start + STICK_SCAN_S, end)
        loose = _push(start, high, phi, q, terms, hidden) > hold
        if loose:
            low = start
            for _ in range(80):
                middle = 0.5 * (low + high)
                if _push(start, middle, phi, q, terms, hidden) > hold:
                    high = middle
                else:
                    low = middle
            _push(start, high, phi, q, terms, hidden)
        hidden[HIDDEN_START] = hidden[HIDDEN_NOW]
        start = high
        if loose:
            return start
    return end


def rest_angle_rad(q: NDArray[np.float64]) -> float:
    """Angle at which nothing pulls, rad; 0 unless a bias torque acts.  Raises ConfigError if there is none."""

    def push(phi: float) -> float:
        return float(drive(0.0, phi, 0.0, q, np.zeros((0, 5)), relaxed(q)))

    if push(0.0) == 0.0:
        return 0.0
    if push(-FARTHEST_RAD) < 0.0 or push(FARTHEST_RAD) > 0.0:
        raise ConfigError(
            "the rotor has no position of rest",
            where="backends.simulated.undeclared, bias_torque",
            why=f"the torque exceeds the restoring torque up to {FARTHEST_RAD} rad",
            remedy="make it weaker; omega_nat^2 is the largest restoring torque per inertia",
        )
    return float(brentq(push, -FARTHEST_RAD, FARTHEST_RAD, xtol=1e-16, rtol=1e-15))

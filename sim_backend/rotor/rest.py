"""A rotor at rest: its equilibrium, its release from dry friction, and its internal state until then."""

from __future__ import annotations

from math import cos

import numpy as np
from numpy.typing import NDArray

from drivers.errors import ConfigError

from .collocation import INTERNAL_NOW, INTERNAL_START, MAX_ITERATIONS, advance
from .internal_state import rates, relaxed
from .kernel import kernel
from .pieces import NODES
from .torque import drive, friction

NOISE = 1e-13  # of the stiffness: accelerations below it are rounding
STICK_SCAN_S = 2e-5
SETTLED = 1e-15
FARTHEST_RAD = 1.5


@kernel
def _relax(h: float, phi: float, q: NDArray[np.float64], internal_state: NDArray[np.float64]) -> None:
    """One collocation step of the internal state, the rotor held at phi; row INTERNAL_NOW contains the end."""
    z = internal_state[INTERNAL_NOW]
    new = np.zeros(z.size)
    for _ in range(MAX_ITERATIONS):
        done = True
        for i in range(NODES):
            advance(i, h, internal_state)
            rates(phi, 0.0, cos(phi), 0.0, z, q, new)
            for k in range(z.size):
                done = done and abs(new[k] - internal_state[i, k]) <= SETTLED * abs(new[k])
                internal_state[i, k] = new[k]
        if done:
            break
    advance(NODES, h, internal_state)


@kernel
def _push(start, at, phi, q, terms, internal_state):  # type: ignore[no-untyped-def]
    """|drive| at a time `at`, with the internal state advanced from `start`."""
    if internal_state.shape[1] > 0:
        _relax(at - start, phi, q, internal_state)
    return abs(drive(at, phi, 0.0, q, terms, internal_state[INTERNAL_NOW]))


@kernel
def release_s(tau, end, phi, q, terms, internal_state):  # type: ignore[no-untyped-def]
    """First time after tau at which |drive| exceeds the static friction, s; `end` if there is none before.

    The internal state, (INTERNAL_ROWS, states), is advanced in place.
    """
    hold = friction(tau, phi, 0.0, q) + NOISE * q[1]
    if terms.shape[0] == 0 and internal_state.shape[1] == 0:
        return end
    start = tau
    while start < end:
        high = min(start + STICK_SCAN_S, end)
        loose = _push(start, high, phi, q, terms, internal_state) > hold
        if loose:
            low = start
            for _ in range(80):
                middle = 0.5 * (low + high)
                if _push(start, middle, phi, q, terms, internal_state) > hold:
                    high = middle
                else:
                    low = middle
            _push(start, high, phi, q, terms, internal_state)
        internal_state[INTERNAL_START] = internal_state[INTERNAL_NOW]
        start = high
        if loose:
            return start
    return end


def rest_angle_rad(q: NDArray[np.float64]) -> float:
    """Angle of equilibrium, rad; 0 unless a bias torque acts.  Raises ConfigError if there is none."""

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
    from scipy.optimize import brentq  # here: it takes long to load, and a plan that moves nothing does without

    return float(brentq(push, -FARTHEST_RAD, FARTHEST_RAD, xtol=1e-16, rtol=1e-15))

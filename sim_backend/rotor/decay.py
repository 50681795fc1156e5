"""The rotor between two shots: it swings on freely, and what is left of it disturbs the next shot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.undeclared.listing import Undeclared

from .hidden import relaxed, rings
from .motion import move
from .rest import rest_angle_rad
from .rotor import Rotor
from .torque import parameters
from .trajectory import energy_amplitude_rad

AT_REST_RAD = 1e-9
STRIDE_S = 5.0


@dataclass(frozen=True)
class Resting:
    """State of the rotor at a world time, nothing driving it; hidden: see `motion.Motion`, None: relaxed."""

    time_s: float = 0.0
    phi_rad: float = 0.0
    phi_dot_rad_per_s: float = 0.0
    hidden: NDArray[np.float64] | None = None


def at_rest(now_s: float, q: NDArray[np.float64]) -> Resting:
    """Hanging at equilibrium.  Raises ConfigError if there is none."""
    return Resting(now_s, rest_angle_rad(q), 0.0, relaxed(q))


def decayed(
    at: Resting, now_s: float, rotor: Rotor, conductance: NDArray[np.float64] | None, undeclared: Undeclared = ()
) -> Resting:
    """The state at `now_s`, by the same equations as within a shot; within 1e-9 rad of equilibrium it counts as still.

    conductance: (2, 2) of the closed loops, see `torque.parameters`; None: no back-action.
    """
    q = parameters(rotor, conductance, undeclared)
    still = at_rest(now_s, q)
    left_s, phi, phi_dot, hidden = now_s - at.time_s, at.phi_rad, at.phi_dot_rad_per_s, at.hidden
    while left_s > 0 and (phi, phi_dot) != (still.phi_rad, 0.0):
        motion = move(0.0, min(left_s, STRIDE_S), phi, phi_dot, q, hidden=hidden)
        left_s, phi, phi_dot, hidden = left_s - STRIDE_S, motion.phi_rad, motion.phi_dot_rad_per_s, motion.hidden
        swing_rad = energy_amplitude_rad(phi - still.phi_rad, phi_dot, rotor.omega_rad_per_s)
        if max(swing_rad, rings(hidden)) < AT_REST_RAD:
            return still
        if motion.stuck:
            break
    return Resting(now_s, phi, phi_dot, hidden)

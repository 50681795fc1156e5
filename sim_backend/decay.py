"""The rotor between two shots: it swings on freely, and what is left of it disturbs the next shot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.motion import move
from sim_backend.rotor import Rotor
from sim_backend.torque import parameters
from sim_backend.trajectory import energy_amplitude_rad

AT_REST_RAD = 1e-9
STRIDE_S = 5.0


@dataclass(frozen=True)
class Resting:
    """State of the rotor at a world time, nothing driving it."""

    time_s: float = 0.0
    phi_rad: float = 0.0
    phi_dot_rad_per_s: float = 0.0

    @property
    def is_still(self) -> bool:
        """True if it hangs at equilibrium."""
        return self.phi_rad == 0.0 and self.phi_dot_rad_per_s == 0.0


def decayed(at: Resting, now_s: float, rotor: Rotor, conductance: NDArray[np.float64] | None) -> Resting:
    """The state at `now_s`, by the same equations as within a shot; below 1e-9 rad it counts as still.

    conductance: (2, 2) of the closed loops, see `torque.parameters`; None: no back-action.
    """
    q = parameters(rotor, conductance)
    left_s, phi, phi_dot = now_s - at.time_s, at.phi_rad, at.phi_dot_rad_per_s
    while left_s > 0 and not at.is_still:
        motion = move(0.0, min(left_s, STRIDE_S), phi, phi_dot, q)
        left_s, phi, phi_dot = left_s - STRIDE_S, motion.phi_rad, motion.phi_dot_rad_per_s
        if energy_amplitude_rad(phi, phi_dot, rotor.omega_rad_per_s) < AT_REST_RAD:
            return Resting(now_s)
        if motion.stuck:
            break
    return Resting(now_s, phi, phi_dot)

"""The rotor between two shots: it swings on freely, and what is left of it disturbs the next shot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .dynamics import Dynamics
from .motion import PIECE_SLOTS, Motion

AT_REST_RAD = 1e-9
STRIDE_S = 5.0


@dataclass(frozen=True)
class Resting:
    """State of the rotor at a world time, nothing driving it; hidden: see `motion.Motion`, None: relaxed."""

    time_s: float = 0.0
    phi_rad: float = 0.0
    phi_dot_rad_per_s: float = 0.0
    hidden: NDArray[np.float64] | None = None


def at_rest(now_s: float, model: Dynamics) -> Resting:
    """Hanging at equilibrium.  Raises ConfigError if there is none."""
    rest = model.rest()
    return Resting(now_s, rest.phi_rad, 0.0, rest.hidden)


def decayed(at: Resting, now_s: float, model: Dynamics, conductance: NDArray[np.float64] | None) -> Resting:
    """The state at `now_s`, by the same equations as within a shot; within 1e-9 rad of equilibrium it counts as still.

    conductance: of the closed loops, see `torque.parameters`; None: no back-action.
    """
    rest = model.rest()
    left_s, hidden = now_s - at.time_s, at.hidden if at.hidden is not None else np.zeros(0)
    now = Motion(np.zeros((0, PIECE_SLOTS)), at.phi_rad, at.phi_dot_rad_per_s, False, hidden)
    while left_s > 0 and (now.phi_rad, now.phi_dot_rad_per_s) != (rest.phi_rad, 0.0):
        now = model.advance(0.0, min(left_s, STRIDE_S), now, conductance=conductance)
        left_s -= STRIDE_S
        if model.from_rest_rad(now, rest) < AT_REST_RAD:
            return Resting(now_s, rest.phi_rad, 0.0, rest.hidden)
        if now.stuck:
            break
    return Resting(now_s, now.phi_rad, now.phi_dot_rad_per_s, now.hidden)

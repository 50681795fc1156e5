"""The rotor between two shots: its free decay, the rest of which disturbs the next shot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .pieces import PIECE_SLOTS, Motion

if TYPE_CHECKING:
    from .dynamics import Dynamics  # loads the compiler, which a world without a rotor does without

AT_REST_RAD = 1e-9
STRIDE_S = 5.0


@dataclass(frozen=True, kw_only=True)
class RotorState:
    """State of the undriven rotor at a world time.

    internal_state: see `motion.Motion`, None: relaxed.
    """

    time_s: float = 0.0
    phi_rad: float = 0.0
    phi_dot_rad_per_s: float = 0.0
    internal_state: NDArray[np.float64] | None = None


def at_rest(now_s: float, model: Dynamics) -> RotorState:
    """The rotor at rest in its equilibrium.  Raises ConfigError if there is none."""
    rest = model.rest()
    return _state(now_s, rest)


def decayed(at: RotorState, now_s: float, model: Dynamics, conductance: NDArray[np.float64] | None) -> RotorState:
    """The state at `now_s`, by the same equations as within a shot; closer than 1e-9 rad to equilibrium it is at rest.

    conductance: of the closed loops, see `torque.parameters`; None: no back-action.  Raises ConfigError as `at_rest`,
    DeviceError as `motion.move`.
    """
    rest = model.rest()
    left_s = now_s - at.time_s
    now = Motion(
        pieces=np.zeros((0, PIECE_SLOTS)),
        phi_rad=at.phi_rad,
        phi_dot_rad_per_s=at.phi_dot_rad_per_s,
        stuck=False,
        internal_state=at.internal_state if at.internal_state is not None else np.zeros(0),
    )
    while left_s > 0 and (now.phi_rad, now.phi_dot_rad_per_s) != (rest.phi_rad, 0.0):
        now = model.advance(0.0, min(left_s, STRIDE_S), now, conductance=conductance)
        left_s -= STRIDE_S
        if model.from_rest_rad(now, rest) < AT_REST_RAD:
            return _state(now_s, rest)
        if now.stuck:
            break
    return _state(now_s, now)


def _state(time_s: float, motion: Motion) -> RotorState:
    """The end of a motion as a state at a world time."""
    return RotorState(
        time_s=time_s,
        phi_rad=motion.phi_rad,
        phi_dot_rad_per_s=motion.phi_dot_rad_per_s,
        internal_state=motion.internal_state,
    )

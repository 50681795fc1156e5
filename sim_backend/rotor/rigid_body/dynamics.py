"""The rigid body behind the interface that every model of the rotor has, see `rotor.dynamics`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.rotor.motion import Motion
from sim_backend.rotor.rotor import Rotor
from sim_backend.undeclared.listing import Undeclared

from .modes import Modes, modes
from .motion import NO_FIELD, RIGID_PIECE_SLOTS, azimuth, move
from .parameters import body_parameters, refuse
from .rest import distance_from_rest, rest_state


@dataclass(frozen=True)
class RigidBody:
    """Five degrees of freedom; `hidden` of its motion is the state of `acceleration`."""

    rotor: Rotor

    @classmethod
    def of(cls, rotor: Rotor, undeclared: Undeclared) -> RigidBody:
        """Raises ConfigError for undeclared torques, which are written for one degree of freedom."""
        refuse(undeclared)
        return cls(rotor)

    def rest(self) -> Motion:
        """See Dynamics.  Raises ConfigError."""
        p = body_parameters(self.rotor)
        state = rest_state(p, self.rotor.omega_rad_per_s)
        return Motion(np.zeros((0, RIGID_PIECE_SLOTS)), azimuth(state, p)[0], 0.0, False, state)

    def advance(
        self,
        start_s: float,
        stop_s: float,
        at: Motion,
        terms: NDArray[np.float64] = NO_FIELD,
        conductance: NDArray[np.float64] | None = None,
        drift_from_s: float | None = None,
    ) -> Motion:
        """See Dynamics; nothing drifts here."""
        p = body_parameters(self.rotor, conductance)
        state = at.hidden if at.hidden.size else self.rest().hidden
        return move(start_s, stop_s, state, p, self.rotor.omega_rad_per_s, terms if len(terms) else NO_FIELD)

    def from_rest_rad(self, at: Motion, rest: Motion) -> float:
        """See Dynamics."""
        return distance_from_rest(at.hidden, rest.hidden, body_parameters(self.rotor), self.rotor.omega_rad_per_s)

    def modes(self) -> Modes:
        """Main and side modes of small motions about rest."""
        return modes(self.rest().hidden, body_parameters(self.rotor))

"""The rigid body as a model of the rotor, see `rotor.dynamics`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.hidden_effects.listing import HiddenEffects
from sim_backend.rotor.pieces import Motion
from sim_backend.rotor.rotor import Rotor

from .modes import Modes, modes
from .motion import NO_FIELD, RIGID_PIECE_SLOTS, azimuth, move
from .parameters import body_parameters, refuse
from .rest import distance_from_rest, rest_state


@dataclass(frozen=True)
class RigidBody:
    """Five degrees of freedom; `internal_state` of a motion is the state of `acceleration`, (STATES,)."""

    rotor: Rotor

    @classmethod
    def of(cls, rotor: Rotor, hidden_effects: HiddenEffects) -> RigidBody:
        """The model of a rotor.  Raises ConfigError for hidden torques, which exist only for one degree of freedom."""
        refuse(hidden_effects)
        return cls(rotor)

    def rest(self) -> Motion:
        """See Dynamics.  Raises ConfigError."""
        p = body_parameters(self.rotor)
        state = rest_state(p, self.rotor.omega_rad_per_s)
        return Motion(
            pieces=np.zeros((0, RIGID_PIECE_SLOTS)),
            phi_rad=azimuth(state, p)[0],
            phi_dot_rad_per_s=0.0,
            stuck=False,
            internal_state=state,
        )

    def advance(
        self,
        start_s: float,
        stop_s: float,
        at: Motion,
        terms: NDArray[np.float64] = NO_FIELD,
        conductance: NDArray[np.float64] | None = None,
        drift_from_s: float | None = None,
    ) -> Motion:
        """See Dynamics; drift_from_s has no effect."""
        p = body_parameters(self.rotor, conductance)
        state = at.internal_state if at.internal_state.size else self.rest().internal_state
        return move(start_s, stop_s, state, p, self.rotor.omega_rad_per_s, terms if len(terms) else NO_FIELD)

    def from_rest_rad(self, at: Motion, rest: Motion) -> float:
        """See Dynamics."""
        return distance_from_rest(
            at.internal_state, rest.internal_state, body_parameters(self.rotor), self.rotor.omega_rad_per_s
        )

    def modes(self) -> Modes:
        """Main and side modes of small motions about rest."""
        return modes(self.rest().internal_state, body_parameters(self.rotor))

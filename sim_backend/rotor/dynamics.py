"""The two models of a rotor's motion: one angle about the main axis, or a rigid body with side modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim_backend.hidden_effects.listing import HiddenEffects

from .internal_state import relaxed, rings
from .motion import move
from .pieces import NO_FIELD, PIECE_SLOTS, Motion
from .rest import rest_angle_rad
from .rotor import Rotor
from .torque import parameters
from .trajectory import energy_amplitude_rad


class Dynamics(Protocol):
    """A model of one rotor.

    Vectors and matrices have one component for each component of dm/dt: u, v, and for a rigid body w.
    """

    def rest(self) -> Motion:
        """The equilibrium, as a motion without pieces.  Raises ConfigError if there is none."""

    def advance(
        self,
        start_s: float,
        stop_s: float,
        at: Motion,
        terms: NDArray[np.float64] = NO_FIELD,
        conductance: NDArray[np.float64] | None = None,
        drift_from_s: float | None = None,
    ) -> Motion:
        """The motion from `start_s` to `stop_s`, s, that continues the end of `at`.

        terms: of the field, times from `start_s` (`Cut.field_terms`); conductance: of the closed loops, see
        `torque.parameters`; drift_from_s: see `extra_torque.fill`.  Raises DeviceError if the integration fails.
        """

    def from_rest_rad(self, at: Motion, rest: Motion) -> float:
        """Distance of a motion's end from rest: the amplitude of its swing, rad, or the deviation of its internal
        states."""


@dataclass(frozen=True)
class SingleAxis:
    """One degree of freedom: eq:Thread_ODE_norm, eq:Jewel_ODE_norm and the hidden torques."""

    rotor: Rotor
    hidden_effects: HiddenEffects

    def rest(self) -> Motion:
        """See Dynamics."""
        q = parameters(self.rotor, hidden_effects=self.hidden_effects)
        return Motion(
            pieces=np.zeros((0, PIECE_SLOTS)),
            phi_rad=rest_angle_rad(q),
            phi_dot_rad_per_s=0.0,
            stuck=False,
            internal_state=relaxed(q),
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
        """See Dynamics."""
        q = parameters(self.rotor, conductance, self.hidden_effects, drift_from_s, start_s)
        return move(start_s, stop_s, at.phi_rad, at.phi_dot_rad_per_s, q, terms, at.internal_state)

    def from_rest_rad(self, at: Motion, rest: Motion) -> float:
        """See Dynamics."""
        swing = energy_amplitude_rad(at.phi_rad - rest.phi_rad, at.phi_dot_rad_per_s, self.rotor.omega_rad_per_s)
        return max(swing, rings(at.internal_state))


def dynamics(rotor: Rotor, hidden_effects: HiddenEffects = ()) -> Dynamics:
    """The model of a rotor: a rigid body if the rotor has one.  Raises ConfigError for hidden torques on a rigid body.

    The rigid body is imported here, so that a world without one neither loads nor compiles it.
    """
    if rotor.body is None:
        return SingleAxis(rotor, hidden_effects)
    from .rigid_body.dynamics import RigidBody

    return RigidBody.of(rotor, hidden_effects)

"""The model that moves a rotor: one angle about the main axis, or a rigid body with side modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim_backend.undeclared.listing import Undeclared

from .hidden import relaxed, rings
from .motion import NO_FIELD, PIECE_SLOTS, Motion, move
from .rest import rest_angle_rad
from .rotor import Rotor
from .torque import parameters
from .trajectory import energy_amplitude_rad


class Dynamics(Protocol):
    """One rotor in motion.  Vectors and matrices have as many components as dm/dt: u, v, and w of a rigid body."""

    def rest(self) -> Motion:
        """Hanging at equilibrium, no pieces.  Raises ConfigError if there is none."""

    def advance(
        self,
        start_s: float,
        stop_s: float,
        at: Motion,
        terms: NDArray[np.float64] = NO_FIELD,
        conductance: NDArray[np.float64] | None = None,
        drift_from_s: float | None = None,
    ) -> Motion:
        """Move on from the end of `at`; terms: of the field, from `start_s` (`Cut.field_terms`); conductance: of the
        closed loops, see `torque.parameters`; drift_from_s: see `extra_torque.fill`.  Raises DeviceError."""

    def from_rest_rad(self, at: Motion, rest: Motion) -> float:
        """How far the end of a motion is from rest: the angle it swings to, or what its hidden states are off."""


@dataclass(frozen=True)
class SingleAxis:
    """One degree of freedom: eq:Thread_ODE_norm, eq:Jewel_ODE_norm and what nobody declared."""

    rotor: Rotor
    undeclared: Undeclared

    def rest(self) -> Motion:
        """See Dynamics."""
        q = parameters(self.rotor, undeclared=self.undeclared)
        return Motion(np.zeros((0, PIECE_SLOTS)), rest_angle_rad(q), 0.0, False, relaxed(q))

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
        q = parameters(self.rotor, conductance, self.undeclared, drift_from_s)
        return move(start_s, stop_s, at.phi_rad, at.phi_dot_rad_per_s, q, terms, at.hidden)

    def from_rest_rad(self, at: Motion, rest: Motion) -> float:
        """See Dynamics."""
        swing = energy_amplitude_rad(at.phi_rad - rest.phi_rad, at.phi_dot_rad_per_s, self.rotor.omega_rad_per_s)
        return max(swing, rings(at.hidden))


def dynamics(rotor: Rotor, undeclared: Undeclared = ()) -> Dynamics:
    """The model that the rotor asks for.  Raises ConfigError for undeclared torques on a rigid body.

    The rigid body is imported here, not above: a world without one neither loads nor compiles it.
    """
    if rotor.body is None:
        return SingleAxis(rotor, undeclared)
    from .rigid_body.dynamics import RigidBody

    return RigidBody.of(rotor, undeclared)

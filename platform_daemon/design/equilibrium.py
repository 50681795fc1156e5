"""Equilibrium of the rotor in its bearing (second step of the paper's procedure), for many cases at once.

Friction and gravity are neglected.  A jewel leaves the rotor's orientation free, so that its moment is parallel to the
field, and the centre moves on a sphere: 2 degrees of freedom.  A thread is a rigid link with ball joints at both ends:
2 degrees of freedom of its lower end and 3 of the rotor.  The energy U(q) is minimised over these coordinates q by
Newton steps dq = -|H|^-1 dU/dq, where |H| is the Hessian with the absolute values of its eigenvalues, so that each step
goes downhill; the start is the position without the defect.  Derivatives of forces and torques are taken by complex
steps, exact to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .dipole import Vectors, cross, dipole_force, dot, rotated, stator_field, unit
from .geometry import Placement, StaticResonator

TOLERANCE = 1e-10  # of the residual of force and torque, where F_m at the distance of the magnets is 3
LONGEST_STEP = 0.2  # rad, round a sphere wider than d: d
SHORTEST_STEP = 1e-9  # same unit; a smaller step ends the iteration
# The restoring force of a flat jewel without tilt is cubic: there each Newton step is only a third shorter than the
# last one, until the stiffness is below rounding error.
SMALLEST_STIFFNESS = 1e-15
STABLE = -1e-6  # stiffness from which a direction counts as flat within rounding
MOST_STEPS = 200
_COMPLEX_STEP = 1e-30
_LEAVES = {  # failures: the rotor is pushed away from the stator, or moves round by more than a quarter turn
    "jewel": ("the rotor would be lifted out of the cup", "the rotor would roll over the rim of the cup"),
    "thread": ("the thread would go slack", "the thread would rise above its anchor"),
}


@dataclass(frozen=True, kw_only=True)
class Equilibria:
    """Equilibria of n cases, lengths in d.

    Attributes:
        placement: stator and bearing, with the rotor in equilibrium.
        centre: C, (n, 3), relative to the stator's centre.
        moment: unit vector of the rotor's moment, (n, 3).
        failure: reason why a case has no equilibrium, "" where it has one, (n,).
    """

    placement: Placement
    centre: Vectors
    moment: Vectors
    failure: NDArray[np.str_]


@dataclass(frozen=True, kw_only=True)
class _State:
    """The coordinates of n rotors; all fields as in Placement."""

    held: Vectors
    towards_anchor: Vectors
    body_axis: Vectors
    moment: Vectors

    def only(self, chosen: NDArray[Any]) -> _State:
        """The rotors that the mask or the indices choose."""
        return _State(
            held=self.held[chosen],
            towards_anchor=self.towards_anchor[chosen],
            body_axis=self.body_axis[chosen],
            moment=self.moment[chosen],
        )

    def put(self, chosen: NDArray[Any], other: _State) -> None:
        """Replace the chosen rotors' coordinates, in place."""
        self.held[chosen] = other.held
        self.towards_anchor[chosen] = other.towards_anchor
        self.body_axis[chosen] = other.body_axis
        self.moment[chosen] = other.moment


@dataclass(frozen=True, kw_only=True)
class _Mechanics:
    """The bearing's geometry (curvature in 1/d, arm in d: see StaticResonator), and the stator of each case."""

    curvature: float
    arm: float
    free: bool  # the rotor rotates freely in its bearing
    stator: Vectors
    stator_moment: Vectors

    def only(self, chosen: NDArray[Any]) -> _Mechanics:
        """The cases that the mask or the indices choose."""
        return replace(self, stator=self.stator[chosen], stator_moment=self.stator_moment[chosen])

    def rotor(self, state: _State) -> tuple[Vectors, Vectors]:
        """The centre C relative to the stator, and the rotor's moment; each (n, 3)."""
        centre = state.held - self.arm * state.body_axis - self.stator
        return centre, unit(stator_field(self.stator_moment, centre)) if self.free else state.moment

    def energy(self, state: _State) -> NDArray[np.float64]:
        """Potential energy of the rotor's dipole in the stator's field, (n,), in units of mu_0 m_r^2 / (4 pi d^3)."""
        centre, moment = self.rotor(state)
        return -dot(moment, stator_field(self.stator_moment, centre))

    def slope(self, state: _State) -> Vectors:
        """Gradient of the energy along x, y, z on the sphere and, unless free, about x, y, z: (n, 3) or (n, 6)."""
        centre, moment = self.rotor(state)
        force = dipole_force(self.stator_moment, moment, centre)
        tangential = force - dot(force, state.towards_anchor)[:, None] * state.towards_anchor
        if self.free:
            return -tangential
        torque = cross(moment, stator_field(self.stator_moment, centre)) - self.arm * cross(state.body_axis, force)
        return np.concatenate([-tangential, -torque], axis=1)

    def moved(self, state: _State, *, shift: Vectors, turn: Vectors) -> _State:
        """The state after a shift along the sphere and a rotation of the rotor, each (n, 3)."""
        length = np.sqrt(dot(shift, shift))[:, None]
        angle = self.curvature * length / np.pi
        lift = self.curvature * length**2 / 2 * np.sinc(angle / 2) ** 2
        up = state.towards_anchor
        return _State(
            held=state.held + np.sinc(angle) * shift + lift * up,
            towards_anchor=unit(up * np.cos(np.pi * angle) - self.curvature * np.sinc(angle) * shift),
            body_axis=unit(rotated(state.body_axis, turn)),
            moment=unit(rotated(state.moment, turn)),
        )

    def perturbed(self, state: _State, *, shift: Vectors, turn: Vectors) -> _State:
        """The state after a shift and a rotation to first order, for complex steps."""
        return _State(
            held=state.held + shift,
            towards_anchor=state.towards_anchor - self.curvature * shift,
            body_axis=state.body_axis + cross(turn, state.body_axis),
            moment=state.moment + cross(turn, state.moment),
        )


def equilibria(resonator: StaticResonator, start: Placement) -> Equilibria:
    """The equilibrium of each of the n cases of a placement."""
    n = start.held.shape[0]
    mechanics = _Mechanics(
        curvature=resonator.curvature,
        arm=resonator.arm,
        free=resonator.bearing == "jewel",
        stator=start.stator,
        stator_moment=start.stator_moment,
    )
    state = _State(
        held=start.held.copy(),
        towards_anchor=start.towards_anchor.copy(),
        body_axis=start.body_axis.copy(),
        moment=start.moment.copy(),
    )
    todo = np.arange(n)
    longest = np.full(n, LONGEST_STEP)
    for _ in range(MOST_STEPS):
        here = mechanics.only(todo)
        now = state.only(todo)
        slope, basis = _slope(here, now)
        step = _step(slope, _stiffness(here, now, basis), longest[todo])
        shift, turn = _as_vectors(step, basis)
        new = here.moved(now, shift=shift, turn=turn)
        lower = here.energy(new) <= here.energy(now) + 1e-13
        longest[todo] *= np.where(lower, np.minimum(2.0, LONGEST_STEP / longest[todo]), 0.25)
        state.put(todo[lower], new.only(lower))
        todo = todo[np.abs(step).max(axis=1) > SHORTEST_STEP]
        if not todo.size:
            break
    rested = replace(
        start,
        held=state.held,
        towards_anchor=state.towards_anchor,
        body_axis=state.body_axis,
        moment=state.moment,
    )
    centre, moment = mechanics.rotor(state)
    failure = _failures(resonator, mechanics, start, state)
    return Equilibria(placement=rested, centre=centre, moment=moment, failure=failure)


def _tangents(normal: Vectors, length: float) -> Vectors:
    """Two vectors of a length, perpendicular to each normal and to each other, (n, 2, 3)."""
    first = unit(cross(np.tile([0.0, 1.0, 0.0], (normal.shape[0], 1)) + 0.1 * np.roll(normal, 1, axis=1), normal))
    return length * np.stack([first, cross(normal, first)], axis=1)


def _slope(mechanics: _Mechanics, state: _State) -> tuple[NDArray[Any], Vectors]:
    """Gradient in the degrees of freedom, (n, 2) or (n, 5), and the tangents of the first two, (n, 2, 3).

    The first two coordinates are lengths in d, or angles in rad on a sphere of a smaller radius, so that a tight cup
    and a wide one have numbers of the same size.
    """
    basis = _tangents(state.towards_anchor, 1 / max(1.0, mechanics.curvature))
    return _in_degrees_of_freedom(mechanics.slope(state), basis), basis


def _in_degrees_of_freedom(slope: Vectors, basis: Vectors) -> NDArray[Any]:
    along = np.einsum("nki,ni->nk", basis, slope[:, :3])
    return np.concatenate([along, slope[:, 3:]], axis=1)


def _as_vectors(step: NDArray[Any], basis: Vectors) -> tuple[Vectors, Vectors]:
    shift = np.einsum("nk,nki->ni", step[:, :2], basis)
    return shift, step[:, 2:] if step.shape[1] == 5 else np.zeros_like(shift)


def _stiffness(mechanics: _Mechanics, state: _State, basis: Vectors) -> NDArray[np.float64]:
    """Second derivatives of the energy, (n, k, k), symmetrised; in equilibrium they are symmetric."""
    count = 2 if mechanics.free else 5
    columns = []
    for k in range(count):
        step = np.zeros((basis.shape[0], count), complex)
        step[:, k] = _COMPLEX_STEP * 1j
        shift, turn = _as_vectors(step, basis)
        slope = mechanics.slope(mechanics.perturbed(state, shift=shift, turn=turn))
        columns.append(_in_degrees_of_freedom(slope, basis).imag / _COMPLEX_STEP)
    matrix = np.stack(columns, axis=2)
    return (matrix + matrix.transpose(0, 2, 1)) / 2


def _step(slope: NDArray[Any], stiffness: NDArray[np.float64], longest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Newton's step (n, k), downhill in every direction and limited to `longest` (n,)."""
    values, vectors = np.linalg.eigh(stiffness)
    along = np.einsum("nij,ni->nj", vectors, slope)
    step = -np.einsum("nij,nj->ni", vectors, along / np.maximum(np.abs(values), SMALLEST_STIFFNESS))
    length = np.maximum(np.abs(step).max(axis=1), 1e-300)
    return np.asarray(step * np.minimum(1.0, longest / length)[:, None])


def _failures(resonator: StaticResonator, mechanics: _Mechanics, start: Placement, state: _State) -> NDArray[np.str_]:
    centre, moment = mechanics.rotor(state)
    force = dipole_force(mechanics.stator_moment, moment, centre)
    slope, basis = _slope(mechanics, state)
    softest = np.linalg.eigvalsh(_stiffness(mechanics, state, basis))[:, 0]
    failure = np.full(centre.shape[0], "", dtype="<U64")
    failure[softest < STABLE] = "where forces balance the rotor is not stable"
    lifted, risen = _LEAVES[resonator.bearing]
    failure[dot(force, state.towards_anchor) > 0] = lifted
    failure[dot(state.towards_anchor, start.towards_anchor) < 0] = risen
    apart = np.sqrt(dot(centre, centre))
    failure[apart < 2 * resonator.radius_m / resonator.distance_m] = "the rotor would touch the stator"
    failure[np.abs(slope).max(axis=1) * apart**4 > TOLERANCE] = "no position of rest was found near where the rotor was"
    return failure

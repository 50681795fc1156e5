"""Where the rotor comes to rest in its bearing (second step of the paper's procedure), many cases at once.

No friction, no gravity.  A jewel leaves the rotor's orientation free, so that its moment is parallel to the field, and
the centre rolls on a sphere: 2 degrees of freedom.  A thread is a rigid link with ball joints at both ends: 2 degrees
of freedom of its lower end and 3 of the rotor.  Newton steps go downhill from where the rotor was without the defect;
derivatives of forces and torques are by complex steps, exact to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .dipole import Vectors, cross, dipole_force, dot, rotated, stator_field, unit
from .geometry import Placement, StaticResonator

TOLERANCE = 1e-10  # of what is left of force and torque, where F_m at the distance of the magnets is 3
LONGEST_STEP = 0.2  # rad, round a sphere wider than d: d
SHORTEST_STEP = 1e-9  # of the same
# A flat jewel without tilt restores with the third power: there Newton's steps shorten by a third only, and go on until
# the stiffness itself drowns in rounding.
SMALLEST_STIFFNESS = 1e-15
STABLE = -1e-6  # stiffness of a direction that is flat but for rounding
MOST_STEPS = 200
_COMPLEX_STEP = 1e-30
_LEAVES = {  # how a rotor leaves its bearing: when pushed from the stator, when further round than a quarter turn
    "jewel": ("the rotor would be lifted out of the cup", "the rotor would roll over the rim of the cup"),
    "thread": ("the thread would go slack", "the thread would rise above its anchor"),
}


@dataclass(frozen=True)
class Equilibria:
    """Where the rotor rests, lengths in d.

    Attributes:
        placement: stator and bearing, and what the bearing holds where it came to rest.
        centre: C, (n, 3), relative to the stator's centre.
        moment: unit vector of the rotor's moment, (n, 3).
        failure: why a case has no equilibrium, "" where it has one, (n,).
    """

    placement: Placement
    centre: Vectors
    moment: Vectors
    failure: NDArray[np.str_]


@dataclass(frozen=True)
class _State:
    """held, towards_anchor, body_axis, moment: as of a Placement."""

    held: Vectors
    towards_anchor: Vectors
    body_axis: Vectors
    moment: Vectors

    def only(self, chosen: NDArray[Any]) -> _State:
        return _State(self.held[chosen], self.towards_anchor[chosen], self.body_axis[chosen], self.moment[chosen])

    def put(self, chosen: NDArray[Any], other: _State) -> None:
        self.held[chosen], self.towards_anchor[chosen] = other.held, other.towards_anchor
        self.body_axis[chosen], self.moment[chosen] = other.body_axis, other.moment


@dataclass(frozen=True)
class _Mechanics:
    """The bearing's geometry, and the stator of each case."""

    curvature: float
    arm: float
    free: bool  # the rotor turns in its bearing as it likes
    stator: Vectors
    stator_moment: Vectors

    def only(self, chosen: NDArray[Any]) -> _Mechanics:
        return replace(self, stator=self.stator[chosen], stator_moment=self.stator_moment[chosen])

    def rotor(self, state: _State) -> tuple[Vectors, Vectors]:
        """(C relative to the stator, the rotor's moment)."""
        centre = state.held - self.arm * state.body_axis - self.stator
        return centre, unit(stator_field(self.stator_moment, centre)) if self.free else state.moment

    def energy(self, state: _State) -> NDArray[np.float64]:
        centre, moment = self.rotor(state)
        return -dot(moment, stator_field(self.stator_moment, centre))

    def slope(self, state: _State) -> Vectors:
        """Slope of the energy along x, y, z on the sphere and, unless free, about x, y, z: (n, 3) or (n, 6)."""
        centre, moment = self.rotor(state)
        force = dipole_force(self.stator_moment, moment, centre)
        tangential = force - dot(force, state.towards_anchor)[:, None] * state.towards_anchor
        if self.free:
            return -tangential
        torque = cross(moment, stator_field(self.stator_moment, centre)) - self.arm * cross(state.body_axis, force)
        return np.concatenate([-tangential, -torque], axis=1)

    def moved(self, state: _State, shift: Vectors, turn: Vectors) -> _State:
        """After a shift along the sphere and a turn of the rotor."""
        length = np.sqrt(dot(shift, shift))[:, None]
        angle = self.curvature * length / np.pi
        lift = self.curvature * length**2 / 2 * np.sinc(angle / 2) ** 2
        up = state.towards_anchor
        return _State(
            state.held + np.sinc(angle) * shift + lift * up,
            unit(up * np.cos(np.pi * angle) - self.curvature * np.sinc(angle) * shift),
            unit(rotated(state.body_axis, turn)),
            unit(rotated(state.moment, turn)),
        )

    def nudged(self, state: _State, shift: Vectors, turn: Vectors) -> _State:
        """The same to first order, for complex steps."""
        return _State(
            state.held + shift,
            state.towards_anchor - self.curvature * shift,
            state.body_axis + cross(turn, state.body_axis),
            state.moment + cross(turn, state.moment),
        )


def equilibria(resonator: StaticResonator, start: Placement) -> Equilibria:
    """Where the rotor comes to rest in each case of a placement."""
    n = start.held.shape[0]
    mechanics = _Mechanics(
        resonator.curvature, resonator.arm, resonator.bearing == "jewel", start.stator, start.stator_moment
    )
    state = _State(start.held.copy(), start.towards_anchor.copy(), start.body_axis.copy(), start.moment.copy())
    todo = np.arange(n)
    longest = np.full(n, LONGEST_STEP)
    for _ in range(MOST_STEPS):
        here, now = mechanics.only(todo), state.only(todo)
        slope, basis = _slope(here, now)
        step = _step(slope, _stiffness(here, now, basis), longest[todo])
        new = here.moved(now, *_as_vectors(step, basis))
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
    return Equilibria(rested, centre, moment, _failures(resonator, mechanics, start, state))


def _tangents(normal: Vectors, length: float) -> Vectors:
    """Two vectors of a length across each normal and each other, (n, 2, 3)."""
    first = unit(cross(np.tile([0.0, 1.0, 0.0], (normal.shape[0], 1)) + 0.1 * np.roll(normal, 1, axis=1), normal))
    return length * np.stack([first, cross(normal, first)], axis=1)


def _slope(mechanics: _Mechanics, state: _State) -> tuple[NDArray[Any], Vectors]:
    """Slope in the degrees of freedom, (n, 2) or (n, 5), and the tangents that the first two are along.

    They count in d, on a sphere of less than that radius in rad: a tight cup has the same numbers as a wide one.
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
    """Second derivatives of the energy, (n, k, k); symmetric at rest, and made so on the way."""
    count = 2 if mechanics.free else 5
    columns = []
    for k in range(count):
        step = np.zeros((basis.shape[0], count), complex)
        step[:, k] = _COMPLEX_STEP * 1j
        slope = mechanics.slope(mechanics.nudged(state, *_as_vectors(step, basis)))
        columns.append(_in_degrees_of_freedom(slope, basis).imag / _COMPLEX_STEP)
    matrix = np.stack(columns, axis=2)
    return (matrix + matrix.transpose(0, 2, 1)) / 2


def _step(slope: NDArray[Any], stiffness: NDArray[np.float64], longest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Newton's step, downhill in every direction, at most so long."""
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

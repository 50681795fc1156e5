"""What stands where, with a defect and before the rotor has moved (paper fig:math_description_angle_defects).

Conventions: the stator's moment is along y, the rotor's opposite, the axis of the bearing is z.  The anchor A is above
the rotor for both bearings: centre of the cup at (0, 0, d + R - r), end of the thread at (0, 0, d + r + l).  What the
bearing holds moves on a sphere about A: the rotor's centre C on radius R - r, the end of the thread, which is a point
of the rotor's surface, on radius l.  Tilts are about x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .dipole import Vectors, rotated

Bearing = Literal["thread", "jewel"]
Defect = Literal["stator_tilt", "rotor_tilt", "jewel_tilt", "lateral"]
Pivot = Literal["contact", "rotor_centre", "stator_centre"]
Direction = Literal["along", "across"]
X, Y, Z = np.eye(3)
SMALLEST_M, LARGEST_M = 1e-9, 1e3
TIGHTEST = 1e7  # in 1/d, of the sphere on which the bearing lets the rotor move


@dataclass(frozen=True)
class StaticResonator:
    """What the static analysis takes of a resonator; lengths in m, remanence in T.

    span_m: radius R of the cup, or length l of the thread from anchor to surface; infinite: flat jewel, or a thread
    that does not tilt.  Raises ValueError where there is no such resonator.
    """

    bearing: Bearing
    radius_m: float
    remanence_t: float
    distance_m: float
    span_m: float

    def __post_init__(self) -> None:
        if not all(SMALLEST_M <= x <= LARGEST_M for x in (self.radius_m, self.distance_m)):
            raise ValueError("radius and distance must be between 1 nm and 1 km")
        if not 0 < self.remanence_t < math.inf:
            raise ValueError("the remanence must be positive and finite")
        if not self.distance_m > 2 * self.radius_m:
            raise ValueError("the magnets overlap: their distance must be more than two radii")
        if not self.span_m > (self.radius_m if self.bearing == "jewel" else 0.0):
            raise ValueError(
                "the rotor does not fit into the cup: its radius must be larger than the rotor's"
                if self.bearing == "jewel"
                else "the length of the thread must be positive"
            )
        if self.curvature > TIGHTEST:
            raise ValueError("the bearing leaves the rotor no play")

    @property
    def curvature(self) -> float:
        """Of the sphere about A, in 1/d."""
        return self.distance_m / (self.span_m - (self.radius_m if self.bearing == "jewel" else 0.0))

    @property
    def arm(self) -> float:
        """From C to what the bearing holds, in d: r for the thread, 0 for the jewel."""
        return self.radius_m / self.distance_m if self.bearing == "thread" else 0.0


@dataclass(frozen=True)
class DefectKind:
    """A defect without its size.

    pivot: about what a jewel is tilted; direction: of a lateral displacement, along or across the magnetisation.
    Raises ValueError for a defect that the bearing cannot have.
    """

    bearing: Bearing
    defect: Defect
    pivot: Pivot = "contact"
    direction: Direction = "along"

    def __post_init__(self) -> None:
        if self.defect == "jewel_tilt" and self.bearing == "thread":
            raise ValueError("a thread bearing has no jewel that could be tilted")
        if self.defect == "rotor_tilt" and self.bearing == "jewel":
            raise ValueError("the rotor of a jewel bearing is attached to nothing and aligns itself with the field")


@dataclass(frozen=True)
class Placement:
    """Where everything is, lengths in d, each (n, 3): stator and its moment, what the bearing holds with the unit
    vector from it towards A, the body's axis from C to that point and the rotor's moment (both of a thread bearing: in
    a jewel they are free), and the axis of the bearing by a point and a direction."""

    stator: Vectors
    stator_moment: Vectors
    held: Vectors
    towards_anchor: Vectors
    body_axis: Vectors
    moment: Vectors
    axis_point: Vectors
    axis: Vectors


def placement(resonator: StaticResonator, kind: DefectKind, sizes: NDArray[np.float64]) -> Placement:
    """With the defect, the rotor still where it was in its bearing.  `sizes`: (n,), rad of a tilt, d of a shift."""
    n = sizes.size
    x, y, z = (np.tile(e, (n, 1)) for e in (X, Y, Z))
    none, turn = np.zeros((n, 3)), sizes[:, None] * x
    stator, stator_moment, rotor_moment, axis_point, axis = none, y, -y, none, z
    held = (1 + resonator.arm) * z
    if kind.defect == "stator_tilt":
        stator_moment = rotated(y, turn)
    elif kind.defect == "rotor_tilt":
        rotor_moment = rotated(-y, turn)
    elif kind.defect == "lateral":
        stator = sizes[:, None] * (y if kind.direction == "along" else x)
    else:
        pivot = _pivot_height(resonator, kind.pivot) * z
        axis = rotated(z, turn)
        held, axis_point = pivot + rotated(held - pivot, turn), pivot
    return Placement(stator, stator_moment, held, axis, z, rotor_moment, axis_point, axis)


def _pivot_height(resonator: StaticResonator, pivot: Pivot) -> float:
    return {"contact": 1 - resonator.radius_m / resonator.distance_m, "rotor_centre": 1.0, "stator_centre": 0.0}[pivot]

"""Geometry of a resonator with a defect, before the rotor has moved (paper fig:math_description_angle_defects).

Conventions: the stator's moment is along y, the rotor's is opposite, the axis of the bearing is z.  The anchor A is
above the rotor for both bearings: centre of the cup at (0, 0, d + R - r), end of the thread at (0, 0, d + r + l).  The
point that the bearing holds moves on a sphere about A: the rotor's centre C on radius R - r, the end of the thread,
which is a point of the rotor's surface, on radius l.  Tilts are about x.
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
    """The parameters of a resonator for the static analysis; lengths in m, remanence in T.

    span_m: radius R of the cup, or length l of the thread from anchor to surface; infinite: flat jewel, or a thread
    that does not tilt.  Raises ValueError for impossible dimensions.
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
        """Curvature of the sphere about A, in 1/d."""
        return self.distance_m / (self.span_m - (self.radius_m if self.bearing == "jewel" else 0.0))

    @property
    def arm(self) -> float:
        """Distance from C to the point that the bearing holds, in d: r for the thread, 0 for the jewel."""
        return self.radius_m / self.distance_m if self.bearing == "thread" else 0.0


@dataclass(frozen=True)
class DefectKind:
    """A defect, without its size.

    pivot: point about which a jewel is tilted; direction: of a lateral displacement, along or across the magnetisation.
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


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Positions and directions of n cases, lengths in d, each (n, 3).

    stator, stator_moment: of the stator; held: the point that the bearing holds; towards_anchor: unit vector from there
    to A; body_axis: unit vector from C to that point, moment: of the rotor (both of a thread bearing; in a jewel they
    are free); axis_point, axis: a point on the axis of the bearing, and its direction.
    """

    stator: Vectors
    stator_moment: Vectors
    held: Vectors
    towards_anchor: Vectors
    body_axis: Vectors
    moment: Vectors
    axis_point: Vectors
    axis: Vectors


def placement(resonator: StaticResonator, kind: DefectKind, sizes: NDArray[np.float64]) -> Placement:
    """The placement with the defect, the rotor at its position without defect; sizes: (n,), rad of a tilt, d of a
    shift."""
    n = sizes.size
    x, y, z = (np.tile(e, (n, 1)) for e in (X, Y, Z))
    none = np.zeros((n, 3))
    turn = sizes[:, None] * x
    stator = none
    stator_moment = y
    rotor_moment = -y
    axis_point = none
    axis = z
    held = (1 + resonator.arm) * z
    if kind.defect == "stator_tilt":
        stator_moment = rotated(y, turn)
    elif kind.defect == "rotor_tilt":
        rotor_moment = rotated(-y, turn)
    elif kind.defect == "lateral":
        stator = sizes[:, None] * (y if kind.direction == "along" else x)
    else:
        axis_point = _pivot_height(resonator, kind.pivot) * z
        axis = rotated(z, turn)
        held = axis_point + rotated(held - axis_point, turn)
    return Placement(
        stator=stator,
        stator_moment=stator_moment,
        held=held,
        towards_anchor=axis,
        body_axis=z,
        moment=rotor_moment,
        axis_point=axis_point,
        axis=axis,
    )


def _pivot_height(resonator: StaticResonator, pivot: Pivot) -> float:
    return {"contact": 1 - resonator.radius_m / resonator.distance_m, "rotor_centre": 1.0, "stator_centre": 0.0}[pivot]

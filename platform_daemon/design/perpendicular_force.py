"""The equivalent perpendicular force of a defect (paper sec. ssec:manufacturing_errors_side_modes, its six steps)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .dipole import Vectors, cross, dipole_force, dot, rotated, stator_field, unit
from .equations import VACUUM_PERMEABILITY
from .equilibrium import Equilibria, equilibria
from .geometry import DefectKind, StaticResonator, placement

CASES_AT_ONCE = 20_000  # bounds the memory of a sweep


class NoEquilibrium(ValueError):
    """The rotor has no equilibrium.

    size: of the first such defect, rad or m; reason: what would happen to the rotor.
    """

    def __init__(self, size: float, reason: str) -> None:
        super().__init__(reason)
        self.size = size
        self.reason = reason


@dataclass(frozen=True, kw_only=True)
class StaticAnalysis:
    """Results for n sizes of a defect, each at k deflections.  The axis of the bearing without defect is z, lengths are
    in m.

    Attributes:
    size: of the defect, rad of a tilt, m of a displacement, (n,).
    deflection_rad: phi, about the new axis from the new position of rest, (k,).
    centre_m: C, centre of the rotor at rest, (n, 3).
    displacement_m: |dy_C|, distance of C from the axis of the bearing (of a tilted jewel: from its own), (n,).
    axis: unit vector of the new axis, from C towards the anchor A, (n, 3).
    moment: unit vector of the rotor's moment at rest, (n, 3).
    alpha_rad: angle between the axis and the moment; 90 deg without defect, (n,).
    reference_point_m: D, where the axis leaves the rotor at the bearing, (n, 3).
    force_n, torque_nm: on the rotor at C, by the stator, (n, k, 3).
    perpendicular_force_n: F_perp = |M_D,perp| / r, (n, k).
    """

    size: NDArray[np.float64]
    deflection_rad: NDArray[np.float64]
    centre_m: Vectors
    displacement_m: NDArray[np.float64]
    axis: Vectors
    moment: Vectors
    alpha_rad: NDArray[np.float64]
    reference_point_m: Vectors
    force_n: NDArray[np.float64]
    torque_nm: NDArray[np.float64]
    perpendicular_force_n: NDArray[np.float64]


def static_analysis(
    resonator: StaticResonator, kind: DefectKind, sizes: Sequence[float], deflections_rad: Sequence[float]
) -> StaticAnalysis:
    """The results for all sizes of a defect, rad or m of a displacement, at all deflections, rad.

    Raises NoEquilibrium for the first size at which the rotor has no equilibrium.
    """
    size, phi = np.asarray(sizes, float), np.asarray(deflections_rad, float)
    d, r = resonator.distance_m, resonator.radius_m
    found = equilibria(resonator, placement(resonator, kind, size / d if kind.defect == "lateral" else size))
    failed = np.flatnonzero(found.failure != "")
    if failed.size:
        raise NoEquilibrium(float(size[failed[0]]), str(found.failure[failed[0]]))
    axis = _new_axis(resonator, found)
    outwards = axis if resonator.bearing == "thread" else -axis  # from C to D
    force, torque, perpendicular = _loads(found, axis, outwards, phi, r / d)
    unit_force = _unit_force(resonator)
    centre = found.centre + found.placement.stator
    apart = cross(centre - found.placement.axis_point, found.placement.axis)
    return StaticAnalysis(
        size=size,
        deflection_rad=phi,
        centre_m=centre * d,
        displacement_m=np.sqrt(dot(apart, apart)) * d,
        axis=axis,
        moment=found.moment,
        alpha_rad=np.arctan2(np.linalg.norm(cross(axis, found.moment), axis=1), dot(axis, found.moment)),
        reference_point_m=centre * d + outwards * r,
        force_n=force * unit_force,
        torque_nm=torque * unit_force * d,
        perpendicular_force_n=perpendicular * unit_force,
    )


def _unit_force(resonator: StaticResonator) -> float:
    """mu_0 m_r^2 / (4 pi d^4), N: a third of F_m (paper eq:fm(phi))."""
    moment = 4 / 3 * math.pi * resonator.radius_m**3 * resonator.remanence_t / VACUUM_PERMEABILITY
    return VACUUM_PERMEABILITY * moment**2 / (4 * math.pi * resonator.distance_m**4)


def _new_axis(resonator: StaticResonator, found: Equilibria) -> Vectors:
    """Third step: through A and C, from C towards A; parallel to the bearing's where A is infinitely far."""
    towards = found.placement.towards_anchor
    if resonator.bearing == "jewel":
        return towards
    return unit(towards + resonator.radius_m / resonator.span_m * found.placement.body_axis)


def _loads(
    found: Equilibria, axis: Vectors, outwards: Vectors, phi: NDArray[np.float64], radius: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Steps four to six: force and torque about C, (n, k, 3), and F_perp, (n, k); dimensionless, radius: r in d."""
    n, k = axis.shape[0], phi.size
    force, torque, perpendicular = np.empty((n, k, 3)), np.empty((n, k, 3)), np.empty((n, k))
    rows = max(1, CASES_AT_ONCE // max(k, 1))
    for first in range(0, n, rows):
        part = slice(first, min(first + rows, n))
        count = part.stop - part.start
        stator, centre, moment, about, out = (
            np.repeat(v[part], k, axis=0)
            for v in (found.placement.stator_moment, found.centre, found.moment, axis, outwards)
        )
        deflected = rotated(moment, np.tile(phi, count)[:, None] * about)
        f, t = dipole_force(stator, deflected, centre), cross(deflected, stator_field(stator, centre))
        about_d = t - radius * cross(out, f)
        tilting = about_d - dot(about_d, about)[:, None] * about
        force[part], torque[part] = f.reshape(count, k, 3), t.reshape(count, k, 3)
        perpendicular[part] = np.sqrt(dot(tilting, tilting)).reshape(count, k) / radius
    return force, torque, perpendicular

"""Helmholtz pairs: their field by Biot-Savart, and by reciprocity their sensitivity to the rotor's moment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.errors import ConfigError
from sim_backend.options import CoilOptions, CoilsOptions
from sim_backend.rotor.rotor import MU_0, rotation_matrix

AXES = ("x", "y", "z")
WIRE = 1e-3  # of the loop's radius: closer than this to a wire the thin-loop formula is not valid


def loop_field_t(radius_m: float, radial_m: float, axial_m: float) -> tuple[float, float]:
    """Radial and axial field of one circular turn, T/A, exact (Biot-Savart in complete elliptic integrals).

    radial_m >= 0 and axial_m are measured from the loop's centre.  Raises ConfigError for a point on the wire, where
    the field is infinite.
    """
    near = (radius_m - radial_m) ** 2 + axial_m**2
    if near < (WIRE * radius_m) ** 2:
        raise ConfigError(
            f"a point {radial_m} m off the axis and {axial_m} m along it lies on the wire of a coil",
            where="position_m",
            remedy="give a position inside the coils",
        )
    far = (radius_m + radial_m) ** 2 + axial_m**2
    m = 4 * radius_m * radial_m / far
    k, e = _complete_elliptic_integrals(m)
    front = MU_0 / (2 * np.pi * np.sqrt(far))
    axial = front * (k + (radius_m**2 - radial_m**2 - axial_m**2) / near * e)
    if radial_m < 1e-9 * radius_m:
        return 0.0, axial
    radial = front * axial_m / radial_m * (-k + (radius_m**2 + radial_m**2 + axial_m**2) / near * e)
    return radial, axial


def _complete_elliptic_integrals(m: float) -> tuple[float, float]:
    """K(m) and E(m) of the parameter m, 0 <= m < 1."""
    if m == 0.0:  # on the axis of the loop, where most platforms measure
        return np.pi / 2, np.pi / 2
    from scipy.special import ellipe, ellipk  # here: it takes long to load

    return float(ellipk(m)), float(ellipe(m))


def pair_field_t(coil: CoilOptions, axis: int, point_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Field per ampere of one pair at a world point: (3,) float64, T/A = V/(A m^2/s) by reciprocity (eq:u(t,p,R))."""
    direction = rotation_matrix(np.array(coil.axis_error_rad)) @ np.eye(3)[axis]
    relative = point_m - np.array(coil.offset_m)
    along = float(relative @ direction)
    across = relative - along * direction
    radial_m = float(np.linalg.norm(across))
    outward = across / radial_m if radial_m > 0 else np.zeros(3)
    total = np.zeros(3)
    for side in (-0.5, 0.5):
        radial, axial = loop_field_t(coil.radius_m, radial_m, along - side * coil.separation_m)
        total += radial * outward + axial * direction
    return coil.turns * total


def sensitivity_t_per_a(coils: CoilsOptions, point_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix (coil, 3) float64, T/A, at point_m (3,), m: row l is the field per ampere of coil l, hence its receive
    sensitivity without gains."""
    return np.stack([pair_field_t(c, axis, point_m) for axis, c in enumerate(coils.in_order())])

"""Whether a rotor stands off the centre of its coils: what the ring-down shows that no parameter of a fit follows.

Off the centre, the pairs' fields are mixed by a matrix that is not 1.  The fit takes a common factor for the moment and
a rotation for the orientation; what is left over are the ratio of odd and even harmonics against the amplitude that the
frequency tells, and the angle between their directions.  Gains and orthogonality do the same, so that they count as
far as they are declared.

Those are two numbers, and a place has three: every one is shown alike by a whole line of places, so that a distance can
only be bounded from below.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .influences import Array, Effect, Situation, pair_fields

_SEEN = 1e-3
"""Chance below which a rotor is called off centre: one shot of a thousand that stand in the centre."""
_RANK = 1e-3  # of the largest: directions of what mixings leave over that are rounding
_FARTHEST = 0.78  # of the smallest radius: no clamp is further off
_DIRECTIONS = 20_000  # 1 degree apart
_MODEL = 0.05
"""Standard uncertainty of the mixing at a place, relative: terms beyond the fourth order, and the place between two of
these directions.  It makes a least distance shorter by 3 % at most."""


@dataclass(frozen=True, kw_only=True)
class OffCentre:
    """What was found.

    Attributes:
        probability: that noise and what is declared of gains and orthogonality make as much.
        distance_m: least distance from the centre, at 95 %; None: nothing is seen, or no place explains it.
    """

    probability: float
    distance_m: float | None

    @property
    def seen(self) -> bool:
        """The rotor is off centre, by more than chance."""
        return self.probability < _SEEN and self.distance_m is not None


def off_centre(given: Situation, effects: Sequence[Effect]) -> OffCentre | None:
    """The test, for one shot; effects: of all influences.  None: an uncalibrated record, or no declared radii."""
    from scipy.special import chdtrc

    radii, response = given.declared.coil_radius_m, given.response
    if response is None or radii is None or len(response.odd) != 3:
        return None
    both = response.odd + response.even
    columns = []
    for row, column in itertools.product(range(3), repeat=2):
        mixing = np.zeros((3, 3))
        mixing[row, column] = 1.0
        columns.append(response.beyond(mixing @ both).ravel())
    matrix = np.array(columns).T
    basis, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    basis = np.asarray(basis[:, sizes > _RANK * sizes[0]], np.float64)
    told = np.asarray(matrix.T @ basis)  # (9, r): what a unit of each mixing shows
    seen = response.left.ravel() @ basis
    spread = np.eye(basis.shape[1]) + _declared(effects, told)
    inverse = np.asarray(np.linalg.inv(spread), np.float64)
    probability = float(chdtrc(basis.shape[1], float(seen @ inverse @ seen)))
    if probability >= _SEEN:
        return OffCentre(probability=probability, distance_m=None)
    return OffCentre(probability=probability, distance_m=least_distance(seen, spread, told, radii))


def _declared(effects: Sequence[Effect], told: Array) -> Array:
    """Covariance (r, r) of what declared gains and angles of the coils show."""
    total = np.zeros((told.shape[1], told.shape[1]))
    for each in effects:
        if each.known is not None and each.mixing is not None:
            shown = each.mixing.ravel() @ told
            total += each.known.u**2 * np.outer(shown, shown)
    return total


def least_distance(seen: Array, spread: Array, told: Array, radii: tuple[float, float, float]) -> float | None:
    """Distance from the centre of the nearest place that explains what is seen, at 95 %, m; None: none does.

    seen: (r,) with covariance spread (r, r); told: (9, r), what a unit of each element of the mixing shows.
    In every direction the mixing grows with the fourth power of the distance, so that the misfit is a parabola of it.
    """
    from scipy.special import chdtri

    smallest = min(radii)
    shown = (pair_fields(smallest * _directions(), radii) - np.eye(3)).reshape(-1, 9) @ told
    inverse = np.linalg.inv(spread + (_MODEL * np.linalg.norm(seen)) ** 2 * np.eye(len(seen)))
    square = np.sum(shown @ inverse * shown, axis=1)
    linear = shown @ inverse @ seen
    over = float(seen @ inverse @ seen) - float(chdtri(len(seen), 0.05))  # what the centre leaves unexplained
    discriminant = linear**2 - square * over
    explains = (linear > 0.0) & (discriminant >= 0.0)
    if not explains.any():
        return None
    fourth = over / (linear[explains] + np.sqrt(discriminant[explains]))
    least = smallest * float(fourth.min()) ** 0.25
    return least if least <= _FARTHEST * smallest else None


def _directions() -> Array:
    """Unit vectors (n, 3), evenly over half a sphere: on its other half the field is the same."""
    k = np.arange(_DIRECTIONS)
    z = (k + 0.5) / _DIRECTIONS
    azimuth = math.pi * (3.0 - math.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), z], axis=1)

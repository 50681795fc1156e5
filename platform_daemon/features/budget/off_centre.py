"""Whether a rotor stands off the centre of its coils: what the ring-down shows that no parameter of a fit follows.

Off the centre, the pairs' fields are mixed by a matrix that is not 1.  The fit takes a common factor for the moment and
a rotation for the orientation; what is left over are the ratio of odd and even harmonics against the amplitude that the
frequency tells, and the angle between their directions.  Gains and orthogonality do the same, so that they count as
far as they are declared.
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
_FARTHEST = 0.45  # of the smallest radius: the fourth order of the field holds there within a few percent
_STARTS = (0.1, 0.25, 0.4)  # of the smallest radius


@dataclass(frozen=True, kw_only=True)
class OffCentre:
    """What was found.

    Attributes:
        probability: that noise and what is declared of gains and orthogonality make as much.
        distance_m: of the nearest place that explains it; None: nothing is seen, or no place explains it.
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
    return OffCentre(probability=probability, distance_m=_nearest(seen, inverse, told, radii))


def _declared(effects: Sequence[Effect], told: Array) -> Array:
    """Covariance (r, r) of what declared gains and angles of the coils show."""
    total = np.zeros((told.shape[1], told.shape[1]))
    for each in effects:
        if each.known is not None and each.mixing is not None:
            shown = each.mixing.ravel() @ told
            total += each.known.u**2 * np.outer(shown, shown)
    return total


def _nearest(seen: Array, inverse: Array, told: Array, radii: tuple[float, float, float]) -> float | None:
    """Distance from the centre of the nearest place that explains what is seen within its deviations."""
    from scipy.optimize import minimize
    from scipy.special import chdtri

    smallest = min(radii)
    allowed = float(chdtri(len(seen), 0.05))

    def missed(place: Array) -> float:
        mixing = (pair_fields(place, radii) - np.eye(3)).ravel()
        over = seen - mixing @ told
        return float(over @ inverse @ over)

    def weighed(over_radius: Array) -> float:
        # The distance weighs little against the misfit: of the places that explain it the nearest is taken.
        return missed(over_radius * smallest) + 1e-2 * float(over_radius @ over_radius)

    found = []
    for size, signs in itertools.product(_STARTS, itertools.product((-1.0, 1.0), repeat=3)):
        start = size * np.array(signs) / math.sqrt(3.0)
        best = minimize(weighed, start, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-4})
        place = best.x * smallest
        if missed(place) <= allowed and float(np.linalg.norm(place)) <= _FARTHEST * smallest * math.sqrt(3.0):
            found.append(float(np.linalg.norm(place)))
    return min(found) if found else None

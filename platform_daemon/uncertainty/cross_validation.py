"""What a calibration is worth for readings that it was not made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drivers.errors import InputError

from .budget import coverage_factor
from .calibration_curve import Points, fit_curve, one_branch
from .curves import Curve

FOLDS = 5
"""Stretches of time that are left out, one after the other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CrossValidation:
    """What a calibration is worth for readings that it was not made of.

    Attributes:
        rms: of x minus the reference; covered: share of them within the interval of 95 %; readings: how many.
    """

    rms: float
    covered: float
    readings: int


def cross_validated(curve: Curve, points: Points) -> CrossValidation:
    """Leave out one stretch of time after the other.  Raises InputError where what is left is too little."""
    places = np.arange(len(points.x))
    errors: list[float] = []
    within: list[bool] = []
    for fold in np.array_split(places, FOLDS):
        kept = np.setdiff1d(places, fold)
        try:
            made = fit_curve(curve, points.some(kept))
        except InputError as error:
            what = f"a cross-validation, which leaves out {len(fold)} of {len(places)} pairs in turn, cannot be made"
            why = f"{error.what} then" + (f", and {error.why}" if error.why else "")
            raise InputError(what, where=error.where, why=why, remedy=error.remedy) from None
        low, high = made.x_range
        wide = one_branch(made, (low - 0.5 * (high - low), high + 0.5 * (high - low)))
        for k in fold:
            second = None if points.second is None else float(points.second[k])
            try:
                told = made.read("x", float(points.f[k]), second, within=wide)
            except InputError:  # further outside than a stretch of time should be
                errors.append(math.inf)
                within.append(False)
                continue
            errors.append(told.value - float(points.x[k]))
            within.append(abs(errors[-1]) <= coverage_factor(0.95, made.dof) * math.hypot(told.u, float(points.u_x[k])))
    finite = np.array(errors)[np.isfinite(errors)]
    if not len(finite):
        what = "a cross-validation finds no reading within the range of the curve"
        why = "with a stretch of time left out, the curve answers to no frequency of that stretch"
        remedy = "record more, or choose a model with fewer parameters"
        raise InputError(what, where="measurand", why=why, remedy=remedy)
    rms = math.sqrt(float(np.mean(finite**2)))
    return CrossValidation(rms=rms, covered=float(np.mean(within)), readings=len(within))

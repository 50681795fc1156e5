"""Comparison of a fit with the truth, in standard deviations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from difflib import get_close_matches
from numbers import Real
from typing import Protocol

from drivers.errors import InputError
from platform_daemon.core.schemas.parameters import PARAMETERS


class _Estimate(Protocol):
    @property
    def value(self) -> float:
        """In SI."""

    @property
    def std(self) -> float | None:
        """Its standard deviation, SI; None: it was held."""


def assert_within(fit: Mapping[str, _Estimate], truth: Mapping[str, float], sigmas: float = 5.0) -> None:
    """Assert that each parameter of a fit is the true one within so many of its standard deviations.

    fit: a Fit of the library, or the `parameters` of a frame; truth: values by public name, SI, as `Recording.truth`;
    sigmas: above 0.  Parameters that only one of the two has, or that were held, are left out; the phase is compared on
    the circle.

    Raises AssertionError that names every parameter that is off, if the fit was refused, or if nothing could be
    compared; InputError where a comparison would say nothing: fit and truth are swapped, a true value is no finite
    number, no parameter has that name, or sigmas is not above 0 and finite.
    """
    _check(fit, truth, sigmas)
    reason = getattr(fit, "reason", None)
    assert reason is None, f"the fit was refused: {reason}"
    off, compared = [], 0
    for name, estimate in fit.items():
        if name not in truth or estimate.std is None:
            continue
        compared += 1
        difference = estimate.value - truth[name]
        if name == "psi_start_rad":
            difference = math.remainder(difference, 2 * math.pi)
        said = f"{name} = {estimate.value:.9g}, true {truth[name]:.9g}"
        if not 0.0 < estimate.std < math.inf:
            off.append(f"{said}, with a standard deviation of {estimate.std:g}")
        elif not abs(difference) <= sigmas * estimate.std:
            off.append(f"{said}: {abs(difference) / estimate.std:.1f} sigma")
    assert compared, f"nothing to compare: the fit has {sorted(fit)}, the truth {sorted(truth)}"
    assert not off, f"beyond {sigmas:g} sigma: {'; '.join(off)}"


def _check(fit: Mapping[str, _Estimate], truth: Mapping[str, float], sigmas: float) -> None:
    """Raises InputError."""
    from platform_daemon.features.fit.fit_request import COEFFICIENTS  # here: it takes long to load

    order = "give the fit first, then the truth: assert_within(fit, shot.truth, sigmas=5)"
    if not (isinstance(fit, Mapping) and all(hasattr(each, "std") for each in fit.values())):
        raise InputError("it has no standard deviations, as a fit has", where="fit", remedy=order)
    if not isinstance(truth, Mapping):
        raise InputError("it is no table of values by name", where="truth", remedy=order)
    known = {*PARAMETERS, *COEFFICIENTS, *fit}
    for name, value in truth.items():
        if name not in known:
            near = get_close_matches(name, known, 1)
            remedy = f"did you mean {near[0]}?" if near else f"one of: {', '.join(sorted(known))}"
            raise InputError(f"no parameter is called {name!r}", where="truth", remedy=remedy)
        if not (isinstance(value, Real) and math.isfinite(value)):
            raise InputError(f"{name} is no finite number", where="truth", remedy=order)
    if not (isinstance(sigmas, Real) and 0.0 < sigmas < math.inf):
        why = "every fit would be within it, or none"
        raise InputError(f"{sigmas!r} is no distance", where="sigmas", why=why, remedy="give a number above 0, as 5")

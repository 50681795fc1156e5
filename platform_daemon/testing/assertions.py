"""Comparison of a fit with the truth, in standard deviations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol


class _Estimate(Protocol):
    @property
    def value(self) -> float:
        """In SI."""

    @property
    def std(self) -> float | None:
        """Its standard deviation, SI; None: it was held."""


def assert_within(fit: Mapping[str, _Estimate], truth: Mapping[str, float], sigmas: float = 5.0) -> None:
    """Assert that each parameter of a fit is the true one within so many of its standard deviations.

    fit: a Fit of the library, or the `parameters` of a frame; truth: values by public name, SI, as `Recording.truth`.
    Parameters that only one of the two has, or that were held, are left out; the phase is compared on the circle.
    Raises AssertionError that names every parameter that is off, or if nothing could be compared.
    """
    off, compared = [], 0
    for name, estimate in fit.items():
        if name not in truth or estimate.std is None:
            continue
        compared += 1
        difference = estimate.value - truth[name]
        if name == "psi_start_rad":
            difference = math.remainder(difference, 2 * math.pi)
        if not abs(difference) <= sigmas * estimate.std:
            distance = abs(difference) / estimate.std
            off.append(f"{name} = {estimate.value:.9g}, true {truth[name]:.9g}: {distance:.1f} sigma")
    assert compared, f"nothing to compare: the fit has {sorted(fit)}, the truth {sorted(truth)}"
    assert not off, f"beyond {sigmas:g} sigma: {'; '.join(off)}"

"""Curves of the perpendicular force for a picture like the paper's figures (fig:F_tan_over_epsilon and appendix)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.specimen import Specimen
from platform_daemon.design.perpendicular_force import NoEquilibrium

from .checked_defect import CheckedDefect
from .numbers import numbers_of

POINTS = 101
MOST_CURVES = 8  # more deflections are a map
SPANS = {"jewel": (5 / 3, 2.0, 4.0, 10.0, 100.0, math.inf), "thread": (1.0, 2.0, 4.0, 8.0, 16.0, math.inf)}


@dataclass(frozen=True)
class ForceCurves:
    """What a picture of a defect shows.

    Attributes:
        size: of the defect, degrees or mm, (n,), from 0 to the largest that was requested.
        phi_deg: deflections, (k,); force_n: at each, (n, k), nan where the rotor comes to rest nowhere.
        spans_over_r: R/r or l/r of the second family, (s,), at `family_phi_deg`; family_force_n: (n, s).
        weight_n: F_g of the rotor, to compare with.
    """

    defect: CheckedDefect
    size: NDArray[np.float64]
    phi_deg: NDArray[np.float64]
    force_n: NDArray[np.float64]
    spans_over_r: tuple[float, ...]
    family_phi_deg: float
    family_force_n: NDArray[np.float64]
    weight_n: float


def force_curves(defect: CheckedDefect, specimen: Specimen | None = None) -> ForceCurves:
    """Force over the size of the defect: at the deflections that were requested, and at one for other bearings.

    More than MOST_CURVES deflections become a fine grid from the smallest to the largest.  `specimen`: whose
    defect it is; None: the paper's design point.
    """
    request = defect.request
    largest = max(map(abs, request.sizes)) or 1.0
    size = np.linspace(0, largest, POINTS)
    phi = np.unique(request.phi_deg)
    if phi.size > MOST_CURVES:
        phi = np.linspace(phi[0], phi[-1], POINTS)
    family_phi = 30.0 if 30.0 in request.phi_deg else float(request.phi_deg[-1])
    spans = tuple(sorted({*SPANS[request.bearing], defect.span_over_r}))
    family = [_forces(_with_span(defect, s), size, np.array([family_phi]))[:, 0] for s in spans]
    force, weight = _forces(defect, size, phi), numbers_of(specimen).f_g_n
    return ForceCurves(defect, size, phi, force, spans, family_phi, np.stack(family, axis=1), weight)


def _with_span(defect: CheckedDefect, span_over_r: float) -> CheckedDefect:
    span = span_over_r * defect.resonator.radius_m
    return replace(defect, resonator=replace(defect.resonator, span_m=span), span_over_r=span_over_r)


def _forces(defect: CheckedDefect, size: NDArray[np.float64], phi: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, k), N; nan from the first size on with which the rotor comes to rest nowhere."""
    found = np.full((size.size, phi.size), np.nan)
    count = size.size
    while count:
        try:
            found[:count] = defect.forces(size[:count].tolist(), phi.tolist()).perpendicular_force_n
            break
        except NoEquilibrium as refused:
            si = math.radians(1) if defect.kind.defect != "lateral" else 1e-3
            count = min(count - 1, int(np.searchsorted(size, refused.size / si * (1 - 1e-9))))
    return found

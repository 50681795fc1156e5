"""Perpendicular forces of a defect, case by case."""

from __future__ import annotations

import math
from typing import Literal

from .checked_defect import CheckedDefect
from .schema import DefectCase, DefectsReport


def defects_report(defect: CheckedDefect) -> DefectsReport:
    """Every size at every deflection.  Raises InputError where the rotor comes to rest nowhere."""
    request = defect.request
    found = defect.analysed(request.sizes, request.phi_deg)
    key = "dy_mm" if request.defect == "lateral" else "eps_deg"
    return DefectsReport.model_validate(
        {
            "bearing": request.bearing,
            "defect": request.defect,
            "cup_radius_over_r" if request.bearing == "jewel" else "thread_length_over_r": ratio(defect.span_over_r),
            "pivot": defect.kind.pivot if request.defect == "jewel_tilt" else None,
            "direction": defect.kind.direction if request.defect == "lateral" else None,
            "cases": [
                DefectCase.model_validate(
                    {
                        key: size,
                        "phi_deg": phi,
                        "f_perp_n": float(found.perpendicular_force_n[i, j]),
                        "dy_c_m": float(found.displacement_m[i]),
                        "alpha_rad": float(found.alpha_rad[i]),
                    }
                )
                for i, size in enumerate(request.sizes)
                for j, phi in enumerate(request.phi_deg)
            ],
        }
    )


def ratio(value: float) -> float | Literal["inf"]:
    """As JSON can hold it."""
    return value if math.isfinite(value) else "inf"

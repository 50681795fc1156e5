"""Fit results inside a recording: `/fit/<name>`, one row per frame."""

from __future__ import annotations

from dataclasses import fields

import h5py
import numpy as np

from .datasets import group, put, put_texts
from .header import FitTable
from .layout import FIT
from .units import unit_of

_TEXTS = ("parameters", "verdict", "reason")
_TEXT = ("variant", "software_version", "correction")
_UNITS = {
    "values": "see parameter_units",
    "std": "see parameter_units",
    "covariance": "see parameter_units, row times column",
    "r2": "1",
    "nrmse": "1",
    "chi2_per_dof": "1",
    "window_s": "s",
}


def write_fit(h5: h5py.File, fit: FitTable) -> None:
    """Write one table, with the unit of each parameter; readers need the names only."""
    made = group(h5, f"{FIT}/{fit.name}", "NXcollection")
    h5[FIT].attrs["NX_class"] = "NXcollection"
    for entry in fields(fit):
        value = getattr(fit, entry.name)
        if entry.name in _TEXTS:
            put_texts(made, entry.name, value)
        elif entry.name in _TEXT:
            if value or entry.name != "correction":
                put(made, entry.name, value)
        elif entry.name != "name":
            put(made, entry.name, np.asarray(value, np.float64), units=_UNITS[entry.name])
    put_texts(made, "parameter_units", (unit_of(name) for name in fit.parameters))
    for name in ("values", "std"):
        made[name].attrs["coordinates"] = "parameter_units"

"""On-line fits as a recording keeps them."""

from __future__ import annotations

from typing import Any

import numpy as np

from .hdf5 import Hdf5File, open_hdf5
from .header import FitTable
from .layout import FIT
from .recording import Recording

_NUMBERS = {"values": 2, "std": 2, "covariance": 3, "r2": 1, "nrmse": 1, "chi2_per_dof": 1, "window_s": 1}
"""How many dimensions each has."""


def read_fit(recording: Recording, name: str) -> FitTable:
    """The table `/fit/<name>`, one of `recording.fits`.

    The covariance is NaN if the file has none.

    Raises RecordingError for a table that is damaged.
    """
    with open_hdf5(recording.path) as source:
        where = f"{FIT}/{name}"
        parameters = _texts(source, f"{where}/parameters", None)
        sizes = (recording.frames, len(parameters), len(parameters))
        numbers: dict[str, Any] = {}
        for key, dimensions in _NUMBERS.items():
            found = source.values(f"{where}/{key}", "s" if key == "window_s" else "")
            if found is None and key == "covariance":  # of another program, or of an earlier version
                found = np.full(sizes, np.nan)
            if found is None or found.shape != sizes[:dimensions]:
                raise source.defect("missing, or of another shape", f"{where}/{key}", f"shape {sizes[:dimensions]}")
            numbers[key] = np.asarray(found, np.float64)
        return FitTable(
            name=name,
            parameters=parameters,
            verdict=_texts(source, f"{where}/verdict", recording.frames),
            reason=_texts(source, f"{where}/reason", recording.frames),
            variant=source.text(f"{where}/variant") or "",
            software_version=source.text(f"{where}/software_version") or "",
            correction=source.text(f"{where}/correction") or "",
            **numbers,
        )


def _texts(source: Hdf5File, name: str, count: int | None) -> tuple[str, ...]:
    found = source.texts(name)
    if found is None or (count is not None and len(found) != count):
        raise source.defect("missing, or of another length", name, "a text per frame" if count else "names")
    return found

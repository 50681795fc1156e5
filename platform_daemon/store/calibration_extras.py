"""What a calibration says of itself beyond P: uncertainty, validity, transmit side.

Not in the minimal table: another writer may use these names for anything, so what is not well-formed is not said.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import TransmitCalibration
from drivers.errors import RecordingError
from platform_daemon.store.hdf5 import Source, open_hdf5
from platform_daemon.store.layout import CALIBRATION, TRANSMIT


def read_extent(source: Source, where: str) -> dict[str, Any]:
    """What the calibration in a group holds for: valid_hz, valid_c, temperature_c; None where it does not say."""
    celsius = _numbers(source, f"{where}/temperature")
    return {
        "valid_hz": _range(source, f"{where}/valid_frequency"),
        "valid_c": _range(source, f"{where}/valid_temperature"),
        "temperature_c": float(celsius.item()) if celsius is not None and celsius.size == 1 else None,
    }


def read_std(source: Source, name: str, shape: tuple[int, ...]) -> NDArray[np.float64] | None:
    """A table of standard deviations of that shape."""
    found = _numbers(source, f"{CALIBRATION}/{name}")
    return found if found is not None and found.shape == shape and np.all(found >= 0) else None


def read_relative_std(source: Source) -> float | None:
    """Relative standard deviation of all of P together."""
    found = read_std(source, "relative_std", ())
    return None if found is None else float(found)


def read_transmit(source: Source) -> TransmitCalibration | None:
    """The measured transmit side, None if there is none or it is not whole."""
    try:
        axes = source.texts(f"{TRANSMIT}/axes")
        identifier, date = (source.text(f"{TRANSMIT}/{name}") for name in ("identifier", "date"))
        complex_ = source.values(f"{TRANSMIT}/field_per_volt")
    except RecordingError:
        return None
    names = ("frequency", "field_per_volt_std", "field_per_ampere", "inductance")
    frequency, std, per_ampere, henry = (_numbers(source, f"{TRANSMIT}/{name}") for name in names)
    if axes is None or identifier is None or date is None or complex_ is None or frequency is None or std is None:
        return None
    if per_ampere is None or henry is None or not np.all(np.isfinite(complex_)):
        return None
    coils = len(axes)
    shapes = (complex_.shape, std.shape, per_ampere.shape, henry.shape)
    if shapes != ((coils, 3, frequency.size), (coils, 3, frequency.size), (coils, 3), (coils,)):
        return None
    values = complex_.astype(np.complex128)
    return TransmitCalibration(
        axes, identifier, date, frequency, values, std, per_ampere, henry, **read_extent(source, TRANSMIT)
    )


def read_transmit_calibration(path: Path | str) -> TransmitCalibration:
    """The transmit side in a calibration file or a recording.  Raises RecordingError if there is none."""
    with open_hdf5(path) as source:
        found = read_transmit(source)
        if found is None:
            remedy = "name a file of `calibrate transmit`, or a recording made with one"
            raise source.defect("missing or not whole", TRANSMIT, "a measured transmit side", remedy)
        return found


def _numbers(source: Source, name: str) -> NDArray[np.float64] | None:
    try:
        found = source.values(name)
    except RecordingError:
        return None
    if found is None or found.dtype.kind == "c" or not np.all(np.isfinite(found)):
        return None
    return np.asarray(found, dtype=np.float64)


def _range(source: Source, name: str) -> tuple[float, float] | None:
    found = _numbers(source, name)
    if found is None or found.shape != (2,) or not found[0] <= found[1]:
        return None
    return float(found[0]), float(found[1])

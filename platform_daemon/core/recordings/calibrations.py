"""Calibration files: NAME@VERSION_DATE.h5, written once and never changed."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from drivers.calibration import MeasuredInfluence, ReceiveCalibration, TransmitCalibration
from drivers.errors import InputError, RecordingError
from platform_daemon.core.state.errors import UnknownUnit
from platform_daemon.core.state.versioned import VersionedFolder

from .checks import check_calibration
from .datasets import put
from .dimensions import add_dimension_scales
from .hdf5 import Hdf5File, open_hdf5
from .layout import CALIBRATION, INFLUENCES, TRANSMIT
from .writer import LIBVER, write_calibration_group, write_transmit_group

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,60}")


def check_calibration_name(name: str) -> None:
    """Raises InputError unless a file can be called so."""
    if not NAME.fullmatch(name):
        remedy = "use letters, digits, - and _"
        raise InputError(f"{name!r} is no name for a calibration", where="name", remedy=remedy)


def add_receive_calibration(
    folder: Path,
    name: str,
    made: datetime,
    calibration: ReceiveCalibration,
    p: NDArray[np.complex128],
) -> Path:
    """A new version of a receive calibration, with what was measured: `p`, (channel, 3, k).

    Its identifier is that of the version.  Raises StorageError, RecordingError if it is not usable.
    """

    def fill(h5: h5py.File, identifier: str) -> None:
        found = replace(calibration, identifier=identifier)
        check_calibration(found, None, name)
        write_calibration_group(h5, found)
        put(h5, f"{CALIBRATION}/p", p, units="T/A", long_name="measured P, complex, (channel, axis, frequency)")

    return _add(folder, name, made, fill)


def add_transmit_calibration(folder: Path, name: str, made: datetime, calibration: TransmitCalibration) -> Path:
    """A new version of a transmit calibration; errors as `add_receive_calibration`."""
    return _add(folder, name, made, lambda h5, label: write_transmit_group(h5, replace(calibration, identifier=label)))


def _add(folder: Path, name: str, made: datetime, fill: Callable[[h5py.File, str], None]) -> Path:
    check_calibration_name(name)
    versions = VersionedFolder(folder, r"_\d{8}\.h5")
    return versions.add(name, f"_{made:%Y%m%d}.h5", lambda number, identifier: _image(identifier, fill)).path


def _image(identifier: str, fill: Callable[[h5py.File, str], None]) -> bytes:
    with h5py.File("calibration", "w", driver="core", backing_store=False, libver=LIBVER) as h5:
        fill(h5, identifier)
        add_dimension_scales(h5)
        h5.flush()
        return bytes(h5.id.get_file_image())


def read_extent(source: Hdf5File, where: str) -> dict[str, Any]:
    """What the calibration in a group holds for: valid_hz, valid_c, temperature_c; None where it does not say."""
    celsius = _numbers(source, f"{where}/temperature", "degC")
    return {
        "valid_hz": _range(source, f"{where}/valid_frequency", "Hz"),
        "valid_c": _range(source, f"{where}/valid_temperature", "degC"),
        "temperature_c": float(celsius.item()) if celsius is not None and celsius.size == 1 else None,
    }


def read_std(source: Hdf5File, name: str, shape: tuple[int, ...], unit: str) -> NDArray[np.float64] | None:
    """A table of standard deviations of that shape, in `unit`.  Raises UnknownUnit."""
    found = _numbers(source, f"{CALIBRATION}/{name}", unit)
    return found if found is not None and found.shape == shape and np.all(found >= 0) else None


def read_relative_std(source: Hdf5File) -> float | None:
    """Relative standard deviation of all of P together."""
    found = read_std(source, "relative_std", (), "1")
    return None if found is None else float(found)


def read_influences(source: Hdf5File) -> tuple[MeasuredInfluence, ...]:
    """What the calibration says it knows of influences; () if it says nothing, or not whole.

    Raises RecordingError for a standard uncertainty that is not above 0.
    """
    try:
        name, kind, why = (source.texts(f"{INFLUENCES}/{each}") for each in ("influence", "type", "source"))
        u, dof = (source.values(f"{INFLUENCES}/{each}", "1") for each in ("u", "dof"))
    except UnknownUnit:
        raise
    except RecordingError:
        return ()
    if name is None or kind is None or why is None or u is None or dof is None:
        return ()
    if {len(kind), len(why), u.size, dof.size} != {len(name)} or "c" in (u.dtype.kind, dof.dtype.kind):
        return ()
    found = []
    for label, size, letter, freedom, said in zip(name, u.ravel(), kind, dof.ravel(), why, strict=True):
        if not (math.isfinite(size) and size > 0.0 and freedom >= 1.0 and letter in ("A", "B")):
            what = f"says u = {size:g} of type {letter} with {freedom:g} degrees of freedom of the {label}"
            remedy = "u is above 0, and there is a degree of freedom: calibrate again, or remove the group"
            raise source.defect(what, INFLUENCES, "a standard uncertainty", remedy)
        free = None if math.isinf(freedom) else float(freedom)
        found.append(MeasuredInfluence(label, float(size), "A" if letter == "A" else "B", free, said))
    return tuple(found)


def read_transmit(source: Hdf5File) -> TransmitCalibration | None:
    """The measured transmit side, None if there is none or it is not whole."""
    try:
        axes = source.texts(f"{TRANSMIT}/axes")
        identifier, date = (source.text(f"{TRANSMIT}/{name}") for name in ("identifier", "date"))
        complex_ = source.values(f"{TRANSMIT}/field_per_volt", "T/V")
    except UnknownUnit:
        raise
    except RecordingError:
        return None
    names = (("frequency", "Hz"), ("field_per_volt_std", "T/V"), ("field_per_ampere", "T/A"), ("inductance", "H"))
    frequency, std, per_ampere, henry = (_numbers(source, f"{TRANSMIT}/{name}", unit) for name, unit in names)
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


def _numbers(source: Hdf5File, name: str, unit: str) -> NDArray[np.float64] | None:
    # Another writer may use the name for anything; but numbers that are used must not be in a unit that is not read.
    try:
        found = source.values(name, unit)
    except UnknownUnit:
        raise
    except RecordingError:
        return None
    if found is None or found.dtype.kind == "c" or not np.all(np.isfinite(found)):
        return None
    return np.asarray(found, dtype=np.float64)


def _range(source: Hdf5File, name: str, unit: str) -> tuple[float, float] | None:
    found = _numbers(source, name, unit)
    if found is None or found.shape != (2,) or not found[0] <= found[1]:
        return None
    return float(found[0]), float(found[1])

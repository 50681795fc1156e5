"""Calibration files: NAME@VERSION_DATE.h5, written once and never changed."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from drivers.calibration import TransmitCalibration
from drivers.errors import InputError
from platform_daemon.store.checks import check_calibration
from platform_daemon.store.durable import PART, storage_error, sync
from platform_daemon.store.layout import CALIBRATION
from platform_daemon.store.recording import Calibration
from platform_daemon.store.writer import LIBVER, put, write_calibration_group, write_transmit_group

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,60}")
_FILE = re.compile(r"(?P<name>[A-Za-z0-9_-]+)@(?P<version>\d+)_\d{8}\.h5")


def check_calibration_name(name: str) -> None:
    """Raises InputError unless a file can be called so."""
    if not NAME.fullmatch(name):
        remedy = "use letters, digits, - and _"
        raise InputError(f"{name!r} is no name for a calibration", where="name", remedy=remedy)


def add_receive_calibration(
    folder: Path,
    name: str,
    made: datetime,
    calibration: Callable[[str], Calibration],
    p: NDArray[np.complex128],
) -> Path:
    """A new version of a receive calibration, with what was measured: `p`, (channel, 3, k).

    `calibration` makes it from the identifier it gets.  Raises StorageError, RecordingError if it is not usable.
    """

    def fill(h5: h5py.File, identifier: str) -> None:
        found = calibration(identifier)
        check_calibration(found, None, name)
        write_calibration_group(h5, found)
        put(h5, f"{CALIBRATION}/p", p, units="T/A", long_name="measured P, complex, (channel, axis, frequency)")

    return _add(folder, name, made, fill)


def add_transmit_calibration(
    folder: Path, name: str, made: datetime, table: Callable[[str], TransmitCalibration]
) -> Path:
    """A new version of a transmit calibration; errors as `add_receive_calibration`."""
    return _add(folder, name, made, lambda h5, identifier: write_transmit_group(h5, table(identifier)))


def _add(folder: Path, name: str, made: datetime, fill: Callable[[h5py.File, str], None]) -> Path:
    """The next free version: linked into place, so that no file is ever replaced, whoever writes at the same time."""
    check_calibration_name(name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        while True:
            target = folder / f"{name}@{_newest(folder, name) + 1}_{made:%Y%m%d}.h5"
            part = target.with_name(f"{target.name}.{os.getpid()}{PART}")
            part.write_bytes(_image(target.stem, fill))
            sync(part)
            try:
                os.link(part, target)
            except FileExistsError:
                continue
            finally:
                part.unlink()
            sync(folder)
            return target
    except OSError as error:
        raise storage_error(folder, error) from error


def _newest(folder: Path, name: str) -> int:
    found = (_FILE.fullmatch(path.name) for path in folder.iterdir())
    return max((int(m["version"]) for m in found if m and m["name"] == name), default=0)


def _image(identifier: str, fill: Callable[[h5py.File, str], None]) -> bytes:
    with h5py.File("calibration", "w", driver="core", backing_store=False, libver=LIBVER) as h5:
        fill(h5, identifier)
        h5.flush()
        return bytes(h5.id.get_file_image())

"""What must hold for a calibration, wherever it comes from: a file, another file, or the engine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

from .layout import FREQUENCY, FREQUENCY_RESPONSE, SENSITIVITY

if TYPE_CHECKING:
    from drivers.calibration import ReceiveCalibration

MAX_CONDITION = 1e6
"""Beyond this, inverting P turns the last bit of a 16-bit converter into the whole signal."""


def check_calibration(calibration: ReceiveCalibration, channels: int | None, where: str) -> None:
    """Raises RecordingError unless P is (channel, 3), finite, invertible and its response table is consistent.

    channels: number of channels of the data, None: no data to compare with; where: the file, for the message.
    """
    p = np.asarray(calibration.sensitivity)
    place = f"{where}:{SENSITIVITY}"
    if p.ndim != 2 or p.shape[1] != 3 or (channels is not None and p.shape[0] != channels):
        raise RecordingError(
            f"sensitivity has shape {p.shape}",
            where=place,
            why=f"Expected ({channels or 'channel'}, 3): one row per channel of /data, columns world x, y, z",
            remedy="write one row per recorded channel, or use a calibration of this platform",
        )
    if not np.all(np.isfinite(p)):
        raise _defect("sensitivity contains NaN or infinity", place, "calibrate again; P is never guessed")
    _check_invertible(p.astype(float), place)
    _check_response(calibration, p.shape[0], where)


def no_calibration_for_counts(where: str) -> RecordingError:
    """A sensitivity is of volts."""
    return RecordingError(
        "holds converter counts, which no calibration applies to",
        where=where,
        why="a sensitivity in T/A is of volts",
        remedy="convert the counts to volts, or leave the calibration out: gains are then free",
    )


def _check_invertible(p: NDArray[np.float64], place: str) -> None:
    # Rows are scaled first: channels of different gain are no defect, parallel or missing directions are.
    norms = np.linalg.norm(p, axis=1)
    rows = p[norms > 0] / norms[norms > 0, None]
    if len(rows) < 3 or np.linalg.cond(rows) > MAX_CONDITION:
        raise RecordingError(
            "sensitivity is singular",
            where=place,
            why="Expected rank 3; otherwise dm/dt = -P^-1 u has no unique solution",
            remedy="calibrate again, or remove /calibration to work in the voltage domain only",
        )


def _check_response(calibration: ReceiveCalibration, channels: int, where: str) -> None:
    f, h = calibration.frequency_hz, calibration.frequency_response
    if f is None and h is None:
        return
    if f is None or h is None:
        missing, present = (FREQUENCY, FREQUENCY_RESPONSE) if f is None else (FREQUENCY_RESPONSE, FREQUENCY)
        raise _defect(f"missing, although {present} exists", f"{where}:{missing}", "write both or neither")
    if f.ndim != 1 or f.size == 0 or not np.all(np.isfinite(f)) or f[0] < 0 or np.any(np.diff(f) <= 0):
        raise _defect(
            "not a rising list of finite frequencies >= 0 Hz", f"{where}:{FREQUENCY}", "sort it and remove duplicates"
        )
    if h.shape != (channels, f.size):
        raise _defect(
            f"shape {h.shape}, expected ({channels}, {f.size}) = (channel, frequency)",
            f"{where}:{FREQUENCY_RESPONSE}",
            "write one value per channel and frequency",
        )
    if not np.all(np.isfinite(h)):
        raise _defect("contains NaN or infinity", f"{where}:{FREQUENCY_RESPONSE}", "measure the response again")


def _defect(what: str, where: str, remedy: str) -> RecordingError:
    return RecordingError(what, where=where, remedy=remedy)

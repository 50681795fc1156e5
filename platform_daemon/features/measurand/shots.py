"""Shots as a sensor's readings: when, at which frequency, how warm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import Measurement, VoltageMeasurement
from platform_daemon.features.fit.series_table import recorded_fits

from .schema import UnreadShot

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Shots:
    """Good fits of shots with a time, in its order.

    Attributes:
        frames: (n) numbers; times_s: (n,) s since 1970; f_hz, std_hz: (n,) natural frequency and what noise leaves.
        celsius: (n,) temperature, NaN: not measured; refused: frames without a fit, with the reason.
    """

    frames: tuple[int, ...]
    times_s: Array
    f_hz: Array
    std_hz: Array
    celsius: Array
    refused: tuple[UnreadShot, ...]


def shots_of(measurement: Measurement, ask: FitRequest) -> Shots:
    """The natural frequencies of a recording.  Raises RecordingError for one without times of its shots."""
    fits = recorded_fits(measurement, ask) or fit_measurement(measurement, ask).frames
    rows, refused = [], []
    for fit in fits:
        if not fit.good:
            refused.append(UnreadShot(frame=fit.frame, reason=fit.reason or ""))
            continue
        found = fit.parameters["f_nat_hz"]
        celsius = measurement.conditions(fit.frame).temperature_c
        rows.append((fit.frame, time_of(measurement, fit.frame), found.value, found.std or 0.0, celsius))
    rows.sort(key=lambda row: row[1])
    return Shots(
        frames=tuple(row[0] for row in rows),
        times_s=np.array([row[1] for row in rows], float),
        f_hz=np.array([row[2] for row in rows], float),
        std_hz=np.array([row[3] for row in rows], float),
        celsius=np.array([row[4] for row in rows], float),
        refused=tuple(refused),
    )


def time_of(measurement: Measurement, frame: int) -> float:
    """When a shot was made, s since 1970.  Raises RecordingError for a file that does not say."""
    stamp = measurement.recording.frame_info[frame].time_stamp if isinstance(measurement, VoltageMeasurement) else None
    where, remedy = str(measurement.path), "use recordings of this software, or another format that keeps them"
    if not stamp:
        raise RecordingError("its shots have no times", where=where, remedy=remedy)
    try:
        return datetime.fromisoformat(stamp).timestamp()
    except ValueError:
        raise RecordingError(f"{stamp!r} is no time of a shot", where=where, remedy=remedy) from None


def joined(parts: Sequence[Shots]) -> Shots:
    """The shots of several recordings, in the order of time; frames are counted through."""
    order = np.argsort(np.concatenate([part.times_s for part in parts]), kind="stable")

    def together(name: str) -> Array:
        return np.asarray(np.concatenate([getattr(part, name) for part in parts])[order])

    return Shots(
        frames=tuple(range(len(order))),
        times_s=together("times_s"),
        f_hz=together("f_hz"),
        std_hz=together("std_hz"),
        celsius=together("celsius"),
        refused=tuple(each for part in parts for each in part.refused),
    )

"""Signals from arrays: a recording or an angle series that is in memory and in no file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError, RecordingError

from .angle_series import AngleSeries, turns_of, unwrapped
from .checks import check_calibration
from .even_clock import evened
from .recording import FrameInfo, Recording, SequenceInfo
from .time_column import even_stretch, fault_of, order_of

Quantity = Literal["dmdt", "voltage", "angle"]
FEWEST = 64
"""Samples of the shortest signal."""
_SHAPES = {
    "dmdt": "(3, n), one row for each world axis, or (frames, 3, n)",
    "voltage": "(channels, n) or (frames, channels, n)",
    "angle": "(n,)",
}


@dataclass(frozen=True, eq=False)
class ArrayRecording(Recording):
    """A recording whose volts are an array.  volts: (frames, channels, n) at the ADC, V."""

    volts: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 0, 0)))

    @property
    def content_key(self) -> tuple[object, ...]:
        """See Recording; the array is kept as long as the key is."""
        return self.path, id(self.volts)

    def frame_volts(self, k: int) -> NDArray[np.float64]:
        """See Recording.  Raises InputError for a frame that does not exist."""
        if not 0 <= k < self.frames:
            remedy = f"frames go from 0 to {self.frames - 1}"
            raise InputError(f"frame {k} does not exist", where=str(self.path), remedy=remedy)
        return self.volts[k]

    def configuration_toml(self) -> str:
        """See Recording: arrays have none."""
        return ""


def signal_of(
    time_s: ArrayLike,
    samples: ArrayLike,
    quantity: Quantity,
    *,
    variant: str | None = None,
    sensitivity: ArrayLike | None = None,
    where: str = "arrays",
) -> Recording | AngleSeries:
    """A signal over time, which begins when the excitation has ended.

    Args:
        time_s: (n,) s, but for an angle without holes, of which the longest stretch without one is taken; samples whose
            stamps are shuffled are sorted, those whose stamps leave an even clock are interpolated; notes say so.
        samples: in SI: dm/dt in A m^2/s on the world axes (3, n), voltages in V (channels, n), both also (frames, ..,
            n), or an angle in rad (n,).
        quantity: what the samples are.
        variant: bearing of the resonator, thread or jewel; None: not said.
        sensitivity: of voltages, (channels, 3) T/A, with which they become dm/dt; None: unknown.
        where: what errors call the arrays.

    Raises InputError for arrays of another shape, samples that are no finite numbers, a time with holes, or angles in
    degrees; RecordingError for a sensitivity that does not fit.
    """
    if quantity not in _SHAPES:
        raise InputError(f"no quantity {quantity!r}", where=where, remedy=f"one of: {', '.join(_SHAPES)}")
    values = _shaped(samples, quantity, where)
    time = np.asarray(time_s, dtype=np.float64)
    sorting = order_of(time) if time.shape == values.shape[-1:] else None
    if sorting is not None:
        time, values = time[sorting[0]], values[..., sorting[0]]
    stretch, clock = _even_stretch(time, values.shape[-1], where, holes=quantity == "angle")
    time, values = time[stretch], values[..., stretch]
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        what = f"{len(bad)} samples are no finite numbers, the first at {tuple(bad[0].tolist())}"
        raise InputError(what, where=where, remedy="cut them off, or replace them by what was measured")
    values, turning = unwrapped(values) if quantity == "angle" else (values, "")
    if quantity == "angle":
        turned = turns_of(values)
        if turned:
            remedy = "convert degrees to radians, or say unit = 'deg' of a file; cut off what turns over"
            raise InputError(f"the angle {turned}", where=where, why="these may be degrees", remedy=remedy)
    values, step_s, evening = evened(time, values, where)
    told = tuple(each for each in ("" if sorting is None else sorting[1], turning, evening) if each)
    if quantity == "angle":
        return AngleSeries(Path(where), values, 1.0 / step_s, clock, told)
    calibration = None
    if quantity == "dmdt":  # u = -P dm/dt with P = 1
        values, sensitivity = -values, np.eye(3)
    if sensitivity is not None:
        calibration = ReceiveCalibration(np.asarray(sensitivity, dtype=np.float64), identifier=f"of {where}")
        check_calibration(calibration, values.shape[1], where)
    frames, channels, n = values.shape
    sequence = SequenceInfo(1.0 / step_s, 1, 0, 0, n)
    info = tuple(FrameInfo(k + 1, n) for k in range(frames))
    layout = "; ".join(told)
    return ArrayRecording(
        Path(where), sequence, frames, channels, info, calibration, variant, other_layout=layout, volts=values
    )


def _shaped(samples: ArrayLike, quantity: str, where: str) -> NDArray[np.float64]:
    """(frames, channels, n), of an angle (1, n).  Raises InputError."""
    try:
        values = np.array(samples, dtype=np.float64)
    except (TypeError, ValueError) as error:
        remedy = "give real numbers, as many in each row"
        raise InputError(
            "the samples are no array of real numbers", where=where, why=str(error), remedy=remedy
        ) from None
    angle = quantity == "angle"
    rows = values if values.ndim == 3 and not angle else np.atleast_2d(values)
    if not angle and rows.ndim == 2:
        rows = rows[None]
    channels = {"dmdt": 3, "angle": 1}.get(quantity)
    if rows.ndim != (2 if angle else 3) or (channels is not None and rows.shape[-2] != channels) or not rows.size:
        turned = values.ndim == 2 and values.shape[1] in (channels, 1) and values.shape[0] > values.shape[1]
        remedy = "transpose it" if turned else f"give {_SHAPES[quantity]}"
        why = f"{quantity} has the shape {_SHAPES[quantity]}"
        raise InputError(f"the array has the shape {values.shape}", where=where, why=why, remedy=remedy)
    return np.ascontiguousarray(rows)


def _even_stretch(time: NDArray[np.float64], samples: int, where: str, *, holes: bool) -> tuple[slice, tuple[str, ...]]:
    """(the samples without a hole in their time, the holes in words).

    holes: there may be some.  Raises InputError for a time that does not go on, one for each sample.
    """
    if time.shape != (samples,):
        remedy = "give one time for each sample, in s"
        raise InputError(f"time has the shape {time.shape}, not ({samples},)", where=where, remedy=remedy)
    if samples < FEWEST:
        raise InputError(f"{samples} samples are fewer than {FEWEST}", where=where, remedy="give a longer signal")
    if not np.isfinite(time).all():
        remedy = "leave samples without a time out, and cut the signal where they are"
        raise InputError("some times are no finite numbers", where=where, remedy=remedy)
    fault = fault_of(time)
    if fault is not None:
        raise InputError(f"time {fault[0]}", where=where, remedy=fault[1])
    first, last, gaps = even_stretch(time)
    if gaps and not (holes and last - first >= FEWEST):
        why = gaps[0].partition(";")[0]
        remedy = f"take samples {first} to {last - 1}, the longest stretch without a hole, or resample the signal"
        raise InputError("time has holes", where=where, why=why, remedy=remedy)
    return slice(first, last), gaps


def refuse_quantities(names: list[str], where: str) -> InputError:
    """The error for columns that cannot belong to one signal."""
    return RecordingError(
        f"the columns {', '.join(names)} are of different quantities",
        where=where,
        remedy="name those of one signal, all in A m^2/s, all in V, or one in rad or deg",
    )

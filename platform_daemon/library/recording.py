"""Recordings as the library has them: opened files, and signals of one's own."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.array_recording import signal_of
from platform_daemon.core.recordings.column_file import Columns, is_column_file, read_columns
from platform_daemon.core.reporting.dataframes import signal_array
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.noise.series import KnownNoise
from platform_daemon.features.fit.measurement import Measurement, VoltageMeasurement, measurement_of, open_measurement

if TYPE_CHECKING:
    import xarray as xr

Quantity = Literal["dmdt", "voltage", "angle"]


class Recording:
    """What was measured: frames of dm/dt, of coil voltages, or of an angle.

    Attributes:
        truth: parameters of a simulated signal by public name, SI; empty if it was measured.
        measurement: as the features of this package take it.
    """

    def __init__(self, measurement: Measurement, truth: Mapping[str, float] | None = None) -> None:
        self.measurement = measurement
        self.truth = dict(truth or {})

    @property
    def name(self) -> str:
        """Path of the file, or what the arrays are called."""
        return str(self.measurement.path)

    @property
    def frames(self) -> int:
        """Number of frames, which are counted from 0."""
        return self.measurement.frames

    @property
    def variant(self) -> str | None:
        """Bearing of the resonator, thread or jewel; None: it is not said."""
        return self.measurement.variant

    @property
    def notes(self) -> tuple[str, ...]:
        """What must be known of it, as holes in its time and samples that were sorted or interpolated."""
        return (*self.measurement.notes, *self.measurement.signal(0).notes)

    def usable_frame(self) -> int:
        """The first frame that is neither blank nor refused.  Raises InputError if there is none."""
        excuses = [self.measurement.excuse(k) for k in range(self.frames)]
        found = next((k for k, excuse in enumerate(excuses) if excuse is None), None)
        if found is None:
            raise InputError(
                "no frame can be used", where=self.name, why=str(excuses[0]), remedy="record excited shots"
            )
        return found

    def quantity(self, frame: int = 0) -> Quantity:
        """What the samples of a frame are: dmdt, voltage or angle."""
        return self.measurement.signal(frame).record.quantity

    def signal(self, frame: int = 0) -> NDArray[np.float64]:
        """The samples of a frame, (channels, n): dm/dt in A m^2/s on the world axes, voltages in V, an angle in rad."""
        return self.measurement.signal(frame).record.samples

    def sampling_rate_hz(self, frame: int = 0) -> float:
        """Samples per second of a frame."""
        return self.measurement.signal(frame).record.sampling_rate_hz

    def time_s(self, frame: int = 0) -> NDArray[np.float64]:
        """Time of each sample of a frame since its first one, s, (n,)."""
        record = self.measurement.signal(frame).record
        return np.arange(record.samples.shape[1]) / record.sampling_rate_hz

    def to_xarray(self, frame: int = 0) -> xr.DataArray:
        """The samples of a frame with the dimensions (channel, time) and units.  Raises InputError without xarray."""
        record = self.measurement.signal(frame).record
        attributes: dict[str, Any] = {"recording": self.name, "frame": frame}
        return signal_array(
            record.samples,
            record.sampling_rate_hz,
            quantity=record.quantity,
            channels=channel_names(record.quantity, record.channels),
            attributes=attributes,
        )

    def __repr__(self) -> str:
        frames = "1 frame" if self.frames == 1 else f"{self.frames} frames"
        return f"<Recording {self.name}: {frames}, {self.variant or 'variant not said'}>"


def check_recording(given: object) -> None:
    """Raises InputError for what is no Recording, as a path."""
    if not isinstance(given, Recording):
        what = f"a {type(given).__name__} is no recording"
        raise InputError(what, where="recording", remedy="open the file first, or make one by from_arrays")


def channel_names(quantity: str, channels: int) -> list[str]:
    """The names of the channels of a signal."""
    return {"dmdt": list("xyz"), "angle": ["phi"]}.get(quantity, [str(k) for k in range(channels)])


def open_recording(
    path: str | os.PathLike[str],
    *,
    time: str | None = None,
    signal: str | Sequence[str] | None = None,
    time_unit: str | None = None,
    unit: str | None = None,
) -> Recording:
    """Open a file: a recording of ours, one in the public MMR layout, an angle series, or a table.

    Tables are CSV and other text, also as LibreOffice, Excel, pandas, numpy, Octave, Tracker and phyphox write it, npz,
    and MATLAB's files.

    Args:
        path: of the file.
        time, signal: columns of a table; None: the names of the columns tell, as `time_s` and `x_am2_per_s`; "0" and
            on where they have no names, `data(:,2)` of a matrix, `run.phi` of a structure.
        time_unit, unit: units of a table's time and signal, as "ms" and "mA m^2/s", "V", "deg"; None: the names tell.

    Raises RecordingError (an InputError) for a file that cannot be read, a column that is not there or has no unit,
    a time with holes, or angles in degrees that are said to be rad.
    """
    place = Path(path)
    if not is_column_file(place):
        if (time, signal, time_unit, unit) != (None, None, None, None):
            remedy = "leave time, signal, time_unit and unit out: the file says what it holds"
            raise InputError("columns are named for a file that is not a table", where=str(place), remedy=remedy)
        return Recording(open_measurement(place))
    if not place.is_file():
        raise RecordingError("there is no such file", where=str(place), remedy="correct the path")
    names = (signal,) if isinstance(signal, str) else None if signal is None else tuple(signal)
    named = Columns(time=time, signal=names, time_unit=time_unit, unit=unit)
    return Recording(measurement_of(read_columns(place, None if named == Columns() else named)))


def from_arrays(
    time_s: ArrayLike,
    dmdt: ArrayLike | None = None,
    *,
    voltage: ArrayLike | None = None,
    angle_rad: ArrayLike | None = None,
    noise: ArrayLike | None = None,
    variant: str | None = None,
    sensitivity: ArrayLike | None = None,
    name: str = "arrays",
) -> Recording:
    """A recording from arrays: one of dmdt, voltage and angle_rad, which begin when the excitation has ended.

    Args:
        time_s: (n,) s, without holes, of which only an angle may have some: its longest stretch without one is taken;
            where it leaves an even clock the samples are interpolated; notes say so.
        dmdt: (3, n) or (frames, 3, n), A m^2/s on the world axes x, y, z.
        voltage: (channels, n) or (frames, channels, n), V.
        angle_rad: (n,), rad.
        noise: standard deviation of one sample in the unit of the signal, one number or one for each channel; None: the
            signal tells it.
        variant: bearing of the resonator, thread or jewel; None: the fit names it.
        sensitivity: of voltages, (channels, 3) T/A, u = -P dm/dt; None: fits estimate what volts tell.
        name: what results and errors call it.

    Raises InputError for arrays of the wrong shape, samples that are no finite numbers, a time with holes, or degrees.
    """
    given: dict[Quantity, ArrayLike] = {}
    for quantity, values in (("dmdt", dmdt), ("voltage", voltage), ("angle", angle_rad)):
        if values is not None:
            given[quantity] = values  # type: ignore[index]
    if len(given) != 1:
        remedy = "give one of dmdt, voltage and angle_rad"
        why = f"there are {len(given)}"
        raise InputError("a recording holds one signal", where=name, why=why, remedy=remedy)
    ((quantity, samples),) = given.items()
    signal = signal_of(time_s, samples, quantity, variant=variant, sensitivity=sensitivity, where=name)
    found = measurement_of(signal)
    if noise is None:
        return Recording(found)
    if not isinstance(found, VoltageMeasurement):
        remedy = "leave noise out: the signal tells it"
        raise InputError("the noise of an angle cannot be given", where=name, remedy=remedy)
    known = KnownNoise(_white(noise, found.recording.channels, found.recording.sequence.rate_hz, name))
    return Recording(VoltageMeasurement.of(found.recording, known_noise=known))


def _white(noise: ArrayLike, channels: int, rate_hz: float, name: str) -> NoiseModel:
    """Raises InputError."""
    sd = np.asarray(noise, dtype=np.float64)
    sd = np.full(channels, float(sd)) if sd.ndim == 0 else sd
    if sd.shape != (channels,) or not (np.isfinite(sd).all() and (sd > 0).all()):
        remedy = f"give one positive number, or {channels}, in the unit of the signal"
        raise InputError(f"the noise has the shape {sd.shape}, or is not positive", where=name, remedy=remedy)
    return NoiseModel.white(sd, rate_hz)

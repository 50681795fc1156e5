"""One frame's dm/dt as an HDF5 file: samples, channels and time as dimension scales, and where it all comes from."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence

import h5py
import numpy as np
from numpy.typing import NDArray

from platform_daemon import __version__

from .datasets import clean, put, put_texts
from .recording import FrameInfo, Recording
from .writer import LIBVER


def dmdt_file(
    samples: NDArray[np.float64],
    first: int,
    *,
    quantity: str,
    unit: str,
    channels: Sequence[str],
    recording: Recording,
    info: FrameInfo,
    identifier: str,
    frame: int,
    notes: Iterable[str] = (),
) -> bytes:
    """The bytes of a file with the data sets `quantity` (channel, time), `channel` (names) and `time` (s).

    samples: (channel, n) in `unit`, beginning with sample `first` of the RX window of the shot of which `info` is;
    recording: the file that they are from; identifier, frame: id of its recording and number there, also where that is
    still in single files.
    """
    rate_hz = recording.sequence.rate_hz
    buffer = io.BytesIO()  # not HDF5's own files in memory: two at a time may not have one name
    with h5py.File(buffer, "w", libver=LIBVER) as h5:
        h5.attrs.update({"sampling_rate_hz": rate_hz, **_source(recording, info, identifier, frame, notes)})
        put_texts(h5, "channel", channels)
        time_s = (first + np.arange(samples.shape[1])) / rate_hz
        put(h5, "time", time_s, units="s", long_name="time since the first RX sample")
        put(h5, quantity, samples, units=unit)
        for dimension, name in zip(h5[quantity].dims, ("channel", "time"), strict=True):
            h5[name].make_scale(name)
            dimension.attach_scale(h5[name])
    return buffer.getvalue()


def _source(
    recording: Recording, info: FrameInfo, identifier: str, frame: int, notes: Iterable[str]
) -> dict[str, str | int]:
    """Attributes that lead back to the recording; what it does not say is left out."""
    origin, calibration, file = recording.provenance, recording.calibration, recording.path
    said = {
        "recording": identifier,
        "file": file.name if file.stem == identifier else f"{identifier}.h5",
        "time_stamp": info.time_stamp,
        "verdict": info.verdict,
        "series_id": origin and origin.series_id,
        "sample": origin and origin.sample_name,
        "recorded_with": origin and f"platform-daemon {origin.software_version}",
        "calibration": calibration and calibration.identifier,
        "calibration_date": calibration and calibration.date,
        "notes": "; ".join(notes),
        "creator": "platform-daemon",
        "creator_version": __version__,
    }
    return {"frame": frame, "shot": info.shot, **{name: clean(text) for name, text in said.items() if text}}

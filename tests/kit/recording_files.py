"""Small recordings for the tests: ours by the writer, others' by plain h5py."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from drivers.calibration import ReceiveCalibration
from platform_daemon.core.recordings.header import FitTable, SeriesHeader, ShotRecord
from platform_daemon.core.recordings.recording import Excitation, SequenceInfo
from platform_daemon.core.recordings.series_writer import SeriesWriter

SEQUENCE = SequenceInfo(125e6, 2048, tx_samples=20, switch_samples=4, rx_samples=100)
P = np.array([[1.12e-3, 8e-6, -5e-6], [-6e-6, 1.05e-3, 9e-6], [4e-6, -7e-6, 8.8e-4]])
START = "2026-03-01T10:00:00+00:00"
EXCITATION = Excitation(
    waveform="sine",
    requested_hz=212.0,
    realised_hz=212.0013,
    field_t=215e-6,
    axis=np.array([1.0, 0.0, 0.0]),
    periods=10.0,
    phase_rad=0.25,
    current_a=np.array([0.2, 0.0, 0.0]),
)


def calibration(**changes: Any) -> ReceiveCalibration:
    whole = {
        "sensitivity": P,
        "identifier": "cal-7",
        "date": "2026-02-28",
        "lna_gain": 100.0,
        "frequency_hz": np.array([100.0, 200.0, 400.0]),
        "frequency_response": np.exp(-0.01j * np.arange(9)).reshape(3, 3),
    }
    return ReceiveCalibration(**(whole | changes))


def header(**changes: Any) -> SeriesHeader:
    whole: dict[str, Any] = {
        "sequence": SEQUENCE,
        "channels": 3,
        "start_time": START,
        "software_version": "1.2.3",
        "variant": "thread",
        "calibration": calibration(),
        "excitation": EXCITATION,
        "planned_shots": 3,
        "title": "a series",
        "sample_name": "T 1",
        "operator": "Ada Łovelace",
        "comment": "first\nsecond",
        "platform": "simulated",
        "configuration_toml": "a = 1\n",
        "channel_names": ("x", "y", "z"),
        "devices": {"io_card": "card 7", "lna": "lna 2"},
    }
    return SeriesHeader(**(whole | changes))


def volts(k: int, channels: int = 3, samples: int = SEQUENCE.total) -> np.ndarray:
    """Shot `k`'s volts: 16-bit steps, different in every shot."""
    return (np.random.default_rng(k).integers(-3000, 3000, (channels, samples)) * (20 / 65536)).astype(np.float32)


def shot(k: int, **changes: Any) -> ShotRecord:
    whole: dict[str, Any] = {
        "volts": volts(k),
        "time_stamp": f"2026-03-01T10:00:{k:02d}+00:00",
        "monotonic_s": 1000.0 + k,
        "temperature_c": 21.5,
        "truth": {"f_nat_hz": 213.0 + k, "effects": {"hum": True}, "note": "ok"},
    }
    return ShotRecord(**(whole | changes))


def write_series(target: Path, count: int = 3, fits: tuple[FitTable, ...] = (), **changes: Any) -> Path:
    with SeriesWriter.create(target, header(**changes)) as writer:
        for k in range(1, count + 1):
            writer.add_shot(shot(k))
        made = writer.finish(fits)
    assert made == target
    return target


def fit_table(frames: int, name: str = "d30") -> FitTable:
    rng = np.random.default_rng(5)
    values = rng.standard_normal((frames, 2))
    values[-1] = np.nan
    return FitTable(
        name=name,
        parameters=("f_nat_hz", "m_r_am2"),
        values=values,
        std=np.abs(values),
        covariance=rng.standard_normal((frames, 2, 2)),
        r2=rng.random(frames),
        nrmse=rng.random(frames),
        chi2_per_dof=rng.random(frames),
        window_s=rng.random(frames),
        verdict=("good",) * (frames - 1) + ("refused",),
        reason=("",) * (frames - 1) + ("no signal",),
        variant="thread",
        software_version="1.2.3",
    )


MINIMAL: Mapping[str, Any] = {
    "/data": np.stack([volts(k) for k in range(2)]),
    "/sequence/baseFrequency": 125e6,
    "/sequence/decimation": 2048,
    "/sequence/numTxSamples": SEQUENCE.tx_samples,
    "/sequence/numSwitchSamples": SEQUENCE.switch_samples,
    "/sequence/numRxSamples": SEQUENCE.rx_samples,
    "/calibration/sensitivity": P,
    "/resonator/variant": "thread",
}


def write_minimal(target: Path, changes: Mapping[str, Any] | None = None) -> Path:
    """A file from elsewhere: `MINIMAL` with changes by path; None leaves out, a function gets (file, path)."""
    with h5py.File(target, "w") as h5:
        for name, value in {**MINIMAL, **(changes or {})}.items():
            if isinstance(value, Callable):  # type: ignore[arg-type]
                value(h5, name)
            elif value is not None:
                h5[name] = value
    return target


NO_FILTER = 64999
"""Number of a filter of HDF5 that there is not."""


def packed_by(number: int, values: np.ndarray) -> Callable[[h5py.File, str], None]:
    """Writes a dataset whose one chunk claims to be packed by a filter of that number."""

    def write(h5: h5py.File, name: str) -> None:
        plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plan.set_chunk(values.shape)
        plan.set_filter(number, h5py.h5z.FLAG_OPTIONAL, ())  # optional, so that HDF5 makes it without the filter
        kind, space = h5py.h5t.py_create(values.dtype), h5py.h5s.create_simple(values.shape)
        group, _, last = name.rpartition("/")
        made = h5py.h5d.create(h5.require_group(group or "/").id, last.encode(), kind, space, plan)
        made.write_direct_chunk((0,) * values.ndim, values.tobytes(), filter_mask=0)

    return write

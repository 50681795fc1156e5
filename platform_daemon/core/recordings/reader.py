"""Opens recordings: the minimal table from anyone, everything else from ourselves.

`/simulation` (the truth of simulated shots) is never opened here; that takes `truth.read_truth`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from drivers.calibration import ReceiveCalibration
from drivers.errors import RecordingError
from platform_daemon.core.state.errors import UnknownUnit

from .calibrations import read_extent, read_influences, read_relative_std, read_std, read_transmit
from .checks import check_calibration, no_calibration_for_counts
from .hdf5 import Hdf5File, open_hdf5
from .layout import (
    CALIBRATION,
    DATA,
    FIT,
    FREQUENCY,
    FREQUENCY_RESPONSE,
    LAYOUT,
    LAYOUT_ATTRIBUTE,
    SENSITIVITY,
    SEQUENCE,
    VARIANT,
    VARIANTS,
)
from .metadata import read_frame_info, read_provenance
from .recording import FrameInfo, Recording, SequenceInfo

ANOTHER_LAYOUT = "convert it to the layout in docs/reference/file-format.md"
_COUNT_NAMES = ("", "1", "count", "counts")
_SLOWEST_CLOCK_HZ = 1e-3  # below, a damaged number: times would overflow


def open_recording(path: Path | str) -> Recording:
    """Open and check a recording of docs/reference/file-format.md; volts are read later, frame by frame.

    Raises RecordingError naming file, HDF5 path, what was expected and a remedy, for any file that is not usable.
    """
    path = Path(path)
    with open_hdf5(path) as source:
        (frames, channels, samples), counts = _data_shape(source)
        sequence = _sequence(source, samples)
        layout = source.attribute("/", LAYOUT_ATTRIBUTE)
        own = layout == LAYOUT
        if own:
            info = read_frame_info(source, frames, samples)
        else:
            info = tuple(FrameInfo(shot=k + 1, valid_samples=samples) for k in range(frames))
        calibration = _calibration(source, channels)
        if counts and calibration is not None:
            raise no_calibration_for_counts(source.place(DATA))
        return Recording(
            path=path,
            sequence=sequence,
            frames=frames,
            channels=channels,
            frame_info=info,
            calibration=calibration,
            variant=_variant(source),
            provenance=read_provenance(source) if own else None,
            fits=source.names(FIT) if own else (),
            size_bytes=source.size_bytes,
            lna_gain=None if calibration is None else calibration.lna_gain,
            counts=counts,
            other_layout="" if layout is None or own else _other_layout(layout),
        )


def _other_layout(layout: object) -> str:
    """What a reader must know of a file of ours whose layout this version does not know."""
    return (
        f"the file was made by another version of this software: its layout is {layout}, this version reads {LAYOUT}; "
        "only samples, sequence, calibration and variant are read: use the version that made it for flags, excitation "
        "and metadata"
    )


def read_calibration(path: Path | str) -> ReceiveCalibration:
    """The calibration in a recording or in a file that holds nothing but `/calibration`.

    Raises RecordingError if there is none, or if it is not usable.
    """
    with open_hdf5(path) as source:
        found = _calibration(source, channels=None)
        if found is None:
            remedy = "name a recording or calibration file with /calibration/sensitivity"
            raise source.defect("missing", SENSITIVITY, "a (channel, 3) sensitivity in T/A", remedy)
        return found


def _data_shape(source: Hdf5File) -> tuple[tuple[int, int, int], bool]:
    """(frames, channels, samples), and whether they are converter counts."""
    found = source.shape(DATA)
    if found is None:
        raise _no_data(source)
    shape, dtype = found
    if len(shape) != 3:
        raise source.defect(f"has shape {shape}", DATA, "three axes (frame, channel, sample)", ANOTHER_LAYOUT)
    if min(shape) >= 1:
        _refuse_reversed(source, (shape[0], shape[1], shape[2]))
    else:
        raise source.defect(f"has shape {shape}", DATA, "at least one frame, channel and sample", "record again")
    if dtype.kind not in "fiu":
        raise source.defect(f"has type {dtype}", DATA, "volts or converter counts, real numbers", "convert it to volts")
    counts = dtype.kind != "f" and not source.is_packed(DATA) and source.units(DATA).lower() in _COUNT_NAMES
    if not counts:
        source.conversion(DATA, "V")
    return (shape[0], shape[1], shape[2]), counts


def _refuse_reversed(source: Hdf5File, shape: tuple[int, int, int]) -> None:
    """Raises RecordingError if the samples look to be along another axis than the last one.

    The window sizes say which axis that is; without them, a frame has more samples than there are frames or channels.
    """
    frames, channels, samples = shape
    sizes = [_count(source, f"num{window}Samples", "1") for window in ("Tx", "Switch", "Rx")]
    named = None if sizes[2] is None else sum(size or 0 for size in sizes)
    if named == samples or (named is None and samples >= max(frames, channels)):
        return
    if named is not None and named not in (frames, channels):
        return  # the sizes contradict the data, whatever its axes are
    raise source.defect(
        f"has shape {shape}, {samples} samples in each of {frames} frames of {channels} channels: the axes look "
        "reversed",
        DATA,
        "three axes (frame, channel, sample)",
        "transpose the data (languages that store columns first show the axes as sample, channel, frame), or name the "
        f"sizes of the windows, as {SEQUENCE}/numRxSamples = {samples}, if they are right",
    )


def _no_data(source: Hdf5File) -> RecordingError:
    names = source.names("/")
    remedy = ANOTHER_LAYOUT
    if {"time", "signal"} <= set(names):
        what = "is a time series (/time, /signal), not a recording of coil voltages"
        remedy = f"fit, slide and diagnose take an angle as it is; for everything else {ANOTHER_LAYOUT}"
    elif set(names) == {"calibration"}:
        what = "holds a calibration only, no recording"
    else:
        what = f"/data is missing; the file has {', '.join('/' + n for n in names[:8]) or 'no objects'}"
        if "time" in names:
            remedy = f"if the file holds the angle of a swing, name it /signal, in rad; for everything else {remedy}"
    return source.defect(what, DATA, "a dataset (frame, channel, sample) in volts", remedy)


def _sequence(source: Hdf5File, samples: int) -> SequenceInfo:
    if not source.has_group(SEQUENCE):
        raise source.defect("missing", SEQUENCE, "a group with baseFrequency and decimation", ANOTHER_LAYOUT)
    base = source.number(f"{SEQUENCE}/baseFrequency", "Hz")
    if base is None or not base >= _SLOWEST_CLOCK_HZ:
        what = "missing" if base is None else f"is {base}"
        remedy = "write the converter clock, 125e6 for a Red Pitaya"
        raise source.defect(
            what, f"{SEQUENCE}/baseFrequency", f"a clock in Hz of at least {_SLOWEST_CLOCK_HZ:g}", remedy
        )
    decimation = _count(source, "decimation", "1")
    if decimation is None or decimation < 1:
        what = "missing" if decimation is None else f"is {decimation}"
        remedy = "write the decimation; sampling rate = baseFrequency / decimation"
        raise source.defect(what, f"{SEQUENCE}/decimation", "an integer of at least 1", remedy)
    return SequenceInfo(float(base), decimation, *_windows(source, samples))


def _windows(source: Hdf5File, samples: int) -> tuple[int, int, int]:
    named = ("numTxSamples", "numSwitchSamples", "numRxSamples")
    tx, switch, rx = (_count(source, name, "samples") for name in named)
    for name, count in zip(named, (tx, switch, rx), strict=True):
        if count is not None and count < 0:
            raise source.defect(f"is {count}", f"{SEQUENCE}/{name}", "0 or more samples")
    before = (tx or 0) + (switch or 0)
    if rx is None and before == 0:
        return 0, 0, samples
    if rx is None or rx < 1 or before + rx != samples:
        shown = " + ".join("absent" if c is None else str(c) for c in (tx, switch, rx))
        expected = f"the {samples} samples of a frame of /data, at least one of them RX"
        remedy = "correct the window sizes, or remove all three if the frames hold RX samples only"
        raise source.defect(f"TX + switch + RX = {shown}", SEQUENCE, expected, remedy)
    return tx or 0, switch or 0, rx


def _count(source: Hdf5File, name: str, unit: str) -> int | None:
    value = source.number(f"{SEQUENCE}/{name}", unit)
    if value is not None and value != int(value):
        raise source.defect(f"is {value}", f"{SEQUENCE}/{name}", "an integer")
    return None if value is None else int(value)


def _variant(source: Hdf5File) -> str | None:
    source.has_group(VARIANT.rpartition("/")[0])
    found = source.text(VARIANT)
    if found is not None and found.strip() not in VARIANTS:
        remedy = "correct it, or remove it and name the variant when fitting"
        raise source.defect(f"is {found!r}", VARIANT, " or ".join(VARIANTS), remedy)
    return None if found is None else found.strip()


def _calibration(source: Hdf5File, channels: int | None) -> ReceiveCalibration | None:
    if not source.has_group(CALIBRATION):
        return None
    p = source.values(SENSITIVITY, "T/A")
    if p is None:
        return None
    if p.dtype.kind == "c":
        raise source.defect("is complex", SENSITIVITY, "real T/A; its phase belongs into frequency_response")
    f, h = source.values(FREQUENCY, "Hz"), source.values(FREQUENCY_RESPONSE, "1")
    if f is not None and f.dtype.kind == "c":
        raise source.defect("is complex", FREQUENCY, "real Hz")
    found = ReceiveCalibration(
        sensitivity=p.astype(np.float64),
        frequency_hz=None if f is None else f.astype(np.float64),
        frequency_response=None if h is None else h.astype(np.complex128),
        identifier=_extra_text(source, "identifier"),
        date=_extra_text(source, "date"),
        lna_gain=_extra_gain(source),
        **read_extent(source, CALIBRATION),
        sensitivity_std=read_std(source, "sensitivity_std", p.shape, "T/A"),
        p_std=None if f is None else read_std(source, "p_std", (*p.shape, f.size), "T/A"),
        relative_std=read_relative_std(source),
        transmit=read_transmit(source),
        influences=read_influences(source),
    )
    check_calibration(found, channels, str(source.path))
    return found


def _extra_text(source: Hdf5File, name: str) -> str | None:
    # Not in the minimal table: another writer may use the name for anything, and its file is still a recording.
    try:
        return source.text(f"{CALIBRATION}/{name}")
    except RecordingError:
        return None


def _extra_gain(source: Hdf5File) -> float | None:
    try:
        gain = source.number(f"{CALIBRATION}/lna_gain", "V/V")
    except UnknownUnit:
        raise
    except RecordingError:
        return None
    return float(gain) if gain is not None and gain > 0 else None

"""Puts the series file together from its shot files: the same at the end of a series and after a crash."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from drivers.errors import RecordingError
from platform_daemon.core.schemas.text import counted
from platform_daemon.core.state.durable import publish, reserve, storage_error

from .datasets import put
from .dimensions import add_dimension_scales
from .fit_tables import write_fit
from .header import FitTable, SeriesHeader
from .layout import DATA, ENTRY
from .reader import open_recording
from .recording import FrameInfo, Recording, SequenceInfo
from .steps import common_windows
from .truth import TRUTH_COLUMNS, read_truth, write_truth
from .writer import LIBVER, create_data, empty_file, link_plot, write_metadata

SPARE_BYTES = 4 << 20


def assemble(
    shots: Sequence[Path],
    part: Path,
    target: Path,
    unreadable: int = 0,
    fits: Sequence[FitTable] = (),
    incomplete: str | None = None,
) -> None:
    """The series of `shots` (at least one) as `target`, which appears by one rename.

    part: where to build it, on the same disk; unreadable: shots that were lost, to be named in the file; incomplete:
    why there are fewer shots than planned, "": there are not, None: as the number of shots says.  Raises StorageError;
    the shots are untouched then.
    """
    recordings = [open_recording(shot) for shot in shots]
    try:
        # All space is requested while refusal is still harmless: HDF5 on a full disk takes the whole process down
        # (segmentation fault in H5Fclose, measured with HDF5 2.0).
        windows = common_windows([recording.sequence for recording in recordings])
        reserve(part, empty_file(), _space_bytes(shots, recordings[0].channels, windows))
        with h5py.File(part, "r+", libver=LIBVER) as h5:
            if incomplete is None:
                incomplete = shortfall(len(recordings), header_of(recordings[0])[0].planned_shots, unreadable)
            _write(h5, recordings, windows, incomplete, fits)
        publish(part, target)
    except (OSError, RuntimeError) as error:  # h5py says RuntimeError when a file cannot be closed
        part.unlink(missing_ok=True)
        raise storage_error(target, error) from error


def _space_bytes(shots: Sequence[Path], channels: int, windows: SequenceInfo) -> int:
    # More than enough: the shots with all their metadata, the uncompressed time axis, tables of fits; zeros before and
    # behind shorter frames, of which gzip leaves a thousandth.
    padding = len(shots) * channels * windows.total * 4 // 200
    return sum(shot.stat().st_size for shot in shots) + 8 * windows.total + padding + SPARE_BYTES


def _write(
    h5: h5py.File,
    recordings: Sequence[Recording],
    windows: SequenceInfo,
    incomplete: str,
    fits: Sequence[FitTable],
) -> None:
    first = recordings[0]
    header, series_id = header_of(first)
    # The last shot is the one of a procedure's series; those of a plain series are all alike.
    header = replace(header, sequence=windows, value_sources=header_of(recordings[-1])[0].value_sources)
    infos = [_placed(recording, windows) for recording in recordings]
    write_metadata(h5, header, series_id, infos)
    if incomplete:
        put(h5[ENTRY], "incomplete", incomplete)
    data = create_data(h5, len(recordings), first.channels, windows.total)
    for k, recording in enumerate(recordings):
        if _lead(recording, windows) == 0 and recording.sequence.total == windows.total:
            _copy_chunks(recording.path, data, k)
        else:
            _copy_padded(recording, windows, data, k)
    known = [read_truth(recording.path) for recording in recordings]
    write_truth(h5, [truth[0] if truth else None for truth in known])
    link_plot(h5, header, infos, with_time=True)
    for fit in fits:
        write_fit(h5, fit)
    add_dimension_scales(h5, further_columns=TRUTH_COLUMNS)


def _lead(recording: Recording, windows: SequenceInfo) -> int:
    """Zeros before the first sample of a shot."""
    return windows.rx_start - recording.sequence.rx_start


def _placed(recording: Recording, windows: SequenceInfo) -> FrameInfo:
    info = recording.frame_info[0]
    return replace(info, valid_samples=_lead(recording, windows) + info.valid_samples)


def _copy_padded(recording: Recording, windows: SequenceInfo, data: h5py.Dataset, k: int) -> None:
    """A shot whose windows are shorter than those of other steps."""
    lead = _lead(recording, windows)
    volts = np.zeros((recording.channels, windows.total), np.float32)
    volts[:, lead : lead + recording.sequence.total] = recording.frame_volts(0)
    data[k] = volts


def _copy_chunks(shot: Path, data: h5py.Dataset, k: int) -> None:
    """Compressed chunks as they are: 10 times faster than unpacking and packing them again, and exact."""
    with h5py.File(shot, "r", locking="best-effort") as source:
        chunks = source[DATA].id
        for channel in range(data.shape[1]):
            mask, packed = chunks.read_direct_chunk((0, channel, 0))
            data.id.write_direct_chunk((k, channel, 0), packed, mask)


def shortfall(shots: int, planned: int | None, unreadable: int) -> str:
    """Why a series is incomplete; "" if it is not.  A series without a planned number is never short by itself."""
    lost = f"; {counted(unreadable, 'shot file')} could not be read" if unreadable else ""
    if planned is not None and shots < planned:
        return f"stopped after {shots} of {planned} shots{lost}"
    return f"{counted(shots, 'shot')} kept{lost}" if lost else ""


def header_of(recording: Recording) -> tuple[SeriesHeader, str]:
    """The header with which this software wrote a recording, and its series id.  Raises RecordingError."""
    p = recording.provenance
    if p is None:
        where, remedy = str(recording.path), "move it out of the staging folder"
        raise RecordingError("not written by this program", where=where, remedy=remedy)
    header = SeriesHeader(
        sequence=recording.sequence,
        channels=recording.channels,
        start_time=p.start_time,
        software_version=p.software_version,
        variant=recording.variant,
        calibration=recording.calibration,
        planned_shots=p.planned_shots,
        title=p.title,
        sample_name=p.sample_name,
        operator=p.operator,
        comment=p.comment,
        platform=p.platform,
        configuration_toml=recording.configuration_toml(),
        channel_names=p.channel_names,
        devices=p.devices,
        value_sources=p.value_sources,
        clock=p.clock,
    )
    return header, p.series_id

"""Puts the series file together from its shot files: the same at the end of a series and after a crash."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import h5py

from drivers.errors import RecordingError

from .dimensions import add_dimension_scales
from .durable import publish, reserve, storage_error
from .fit_tables import write_fit
from .header import FitTable, SeriesHeader
from .layout import DATA, ENTRY
from .reader import open_recording
from .recording import Recording
from .truth import TRUTH_COLUMNS, read_truth, write_truth
from .writer import LIBVER, create_data, empty_file, link_plot, put, write_metadata

SPARE_BYTES = 4 << 20


def assemble(
    shots: Sequence[Path], part: Path, target: Path, unreadable: int = 0, fits: Sequence[FitTable] = ()
) -> None:
    """The series of `shots` (at least one) as `target`, which appears by one rename.

    part: where to build it, on the same disk; unreadable: shots that were lost, to be named in the file.  Raises
    StorageError; the shots are untouched then.
    """
    recordings = [open_recording(shot) for shot in shots]
    try:
        # All space is asked for while refusal is still harmless: HDF5 on a full disk takes the whole process down
        # (segmentation fault in H5Fclose, measured with HDF5 2.0).
        reserve(part, empty_file(), _space_bytes(shots, recordings[0]))
        with h5py.File(part, "r+", libver=LIBVER) as h5:
            _write(h5, recordings, unreadable, fits)
        publish(part, target)
    except (OSError, RuntimeError) as error:  # h5py says RuntimeError when a file cannot be closed
        part.unlink(missing_ok=True)
        raise storage_error(target, error) from error


def _space_bytes(shots: Sequence[Path], first: Recording) -> int:
    # More than enough: the shots with all their metadata, the uncompressed time axis, tables of fits.
    return sum(shot.stat().st_size for shot in shots) + 8 * first.sequence.total + SPARE_BYTES


def _write(h5: h5py.File, recordings: Sequence[Recording], unreadable: int, fits: Sequence[FitTable]) -> None:
    first = recordings[0]
    header, series_id = header_of(first)
    infos = [recording.frame_info[0] for recording in recordings]
    write_metadata(h5, header, series_id, infos)
    incomplete = shortfall(len(recordings), header.planned_shots, unreadable)
    if incomplete:
        put(h5[ENTRY], "incomplete", incomplete)
    data = create_data(h5, len(recordings), first.channels, first.sequence.total)
    for k, recording in enumerate(recordings):
        _copy_chunks(recording.path, data, k)
    known = [read_truth(recording.path) for recording in recordings]
    write_truth(h5, [truth[0] if truth else None for truth in known])
    link_plot(h5, header, infos, with_time=True)
    for fit in fits:
        write_fit(h5, fit)
    add_dimension_scales(h5, further_columns=TRUTH_COLUMNS)


def _copy_chunks(shot: Path, data: h5py.Dataset, k: int) -> None:
    """Compressed chunks as they are: 10 times faster than unpacking and packing them again, and exact."""
    with h5py.File(shot, "r", locking="best-effort") as source:
        chunks = source[DATA].id
        for channel in range(data.shape[1]):
            mask, packed = chunks.read_direct_chunk((0, channel, 0))
            data.id.write_direct_chunk((k, channel, 0), packed, mask)


def shortfall(shots: int, planned: int | None, unreadable: int) -> str:
    """Why a series is incomplete; "" if it is not.  A series without a planned number is never short by itself."""
    lost = f"; {unreadable} shot files were unreadable" if unreadable else ""
    if planned is not None and shots < planned:
        return f"stopped after {shots} of {planned} shots{lost}"
    return f"{shots} shots kept{lost}" if lost else ""


def header_of(recording: Recording) -> tuple[SeriesHeader, str]:
    """The header that a recording of ours was written with, and its series id.  Raises RecordingError."""
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
    )
    return header, p.series_id

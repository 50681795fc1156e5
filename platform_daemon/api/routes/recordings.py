"""Recordings on disk: list, describe, download, calibrated dm/dt for plots and in full."""

from __future__ import annotations

import io
from dataclasses import asdict
from typing import Annotated, Any, Literal
from urllib.parse import quote

import numpy as np
from fastapi import APIRouter, Query, Response
from fastapi.responses import FileResponse

from drivers.errors import InputError
from platform_daemon.analysis import calibrated_signal, min_max_decimate
from platform_daemon.estimation import RingDownRecord
from platform_daemon.store import Recording, describe, dmdt_file, list_recordings, open_recording, resolve

from ..context import Shared
from ..models import DmdtModel, ProblemModel
from ..problems import problem

router = APIRouter(prefix="/recordings", tags=["recordings"])
ERRORS: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 422: {"model": ProblemModel}}


def opened(identifier: str, context: Shared) -> Recording:
    """The recording of that id.  Raises UnknownRecording, RecordingError."""
    return open_recording(resolve(context.recordings, identifier))


@router.get("", summary="All recordings")
def list_recordings_in_folder(context: Shared) -> dict[str, Any]:
    """Every recording, and every file that cannot be read with the reason."""
    found = list_recordings(context.recordings)
    entries = [{**asdict(e), "path": e.path.name, "links": _links(e.identifier)} for e in found.recordings]
    broken = [{"identifier": b.identifier, "path": b.path.name, "error": problem(b.error)} for b in found.broken]
    return {"recordings": entries, "broken": broken}


@router.get("/{identifier}", summary="What a recording holds", responses=ERRORS)
def get_recording(identifier: str, context: Shared) -> dict[str, Any]:
    """What the recording says: sequence, calibration, frames with verdicts, sample, operator."""
    recording = opened(identifier, context)
    return {"id": identifier, **describe(recording), "file": recording.path.name, "links": _links(identifier)}


def _links(identifier: str) -> dict[str, str]:
    base = f"/recordings/{quote(identifier)}"
    return {"self": base, "file": f"{base}/file", "dmdt": f"{base}/frames/0/dmdt"}


@router.get("/{identifier}/file", summary="The file itself", responses=ERRORS)
def download_recording(identifier: str, context: Shared) -> FileResponse:
    """The whole file (HDF5, NeXus, `.mmr`)."""
    path = opened(identifier, context).path
    return FileResponse(path, media_type="application/x-hdf5", filename=path.name)


@router.get(
    "/{identifier}/frames/{frame}/dmdt",
    summary="Calibrated dm/dt of a frame",
    response_model=DmdtModel,
    responses=ERRORS,
)
def get_dmdt(
    identifier: str,
    frame: int,
    context: Shared,
    format: Annotated[
        Literal["json", "npy", "h5"], Query(description="json is decimated, npy and h5 are full")
    ] = "json",
    points: Annotated[int, Query(ge=2, le=100_000, description="at most so many points per channel")] = 2000,
    start_s: Annotated[float, Query(ge=0, le=1e6, description="from, s after the first RX sample")] = 0.0,
    stop_s: Annotated[float | None, Query(gt=0, le=1e6, description="to, s; default: the end")] = None,
) -> Any:
    """dm/dt = -P^-1 u in A m^2/s, world axes; the RX volts if the recording has no calibration.

    `npy`: float64 (3, n); `h5`: datasets `dmdt` (3, n), `channel` (3,) and `time` (n,) as dimension scales, units, and
    as attributes of the file the sampling rate and the source (recording, frame, calibration, software).
    """
    recording = opened(identifier, context)
    rate = recording.sequence.rate_hz
    signal = calibrated_signal(recording.rx_volts(frame), rate, recording.calibration)
    record, assumed = signal.record, signal.notes
    first, last = _span(record.samples.shape[1], rate, start_s, stop_s)
    cut = record.samples[:, first:last]
    if format == "json":
        return {**_points(identifier, frame, record, cut, first, points), "notes": _notes(record, assumed)}
    name = f"{identifier}-frame{frame}-{record.quantity}.{format}"
    body = _npy(cut) if format == "npy" else _h5(cut, first, record, recording, frame, _notes(record, assumed))
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(body, media_type="application/octet-stream", headers=headers)


def _span(samples: int, rate_hz: float, start_s: float, stop_s: float | None) -> tuple[int, int]:
    """Sample range of a time range.  Raises InputError if it is empty or leaves the RX window."""
    first, last = round(start_s * rate_hz), samples if stop_s is None else round(stop_s * rate_hz)
    if not 0 <= first < last <= samples:
        remedy = f"ask for times from 0 to {samples / rate_hz:.6f} s, start_s before stop_s"
        raise InputError("the time range holds no samples of this frame", where="start_s, stop_s", remedy=remedy)
    return first, last


def _points(identifier: str, frame: int, record: RingDownRecord, cut: Any, first: int, points: int) -> dict[str, Any]:
    size, low, high = min_max_decimate(cut, points)
    start = (first + size * np.arange(low.shape[1])) / record.sampling_rate_hz
    return {
        "recording": identifier,
        "frame": frame,
        "quantity": record.quantity,
        "unit": _unit(record),
        "channels": _channels(record),
        "sampling_rate_hz": record.sampling_rate_hz,
        "samples": cut.shape[1],
        "samples_per_point": size,
        "t_s": start.tolist(),
        "minimum": low.tolist(),
        "maximum": high.tolist(),
    }


def _notes(record: RingDownRecord, assumed: tuple[str, ...]) -> list[str]:
    bare = [] if record.quantity == "dmdt" else ["the recording has no calibration: these are volts at the ADC input"]
    return [*bare, *assumed]


def _channels(record: RingDownRecord) -> list[str]:
    return list("xyz") if record.quantity == "dmdt" else [str(c) for c in range(record.samples.shape[0])]


def _unit(record: RingDownRecord) -> str:
    return "A m^2/s" if record.quantity == "dmdt" else "V"


def _npy(cut: Any) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.ascontiguousarray(cut))
    return buffer.getvalue()


def _h5(cut: Any, first: int, record: RingDownRecord, recording: Recording, frame: int, notes: list[str]) -> bytes:
    names = () if record.quantity == "dmdt" or recording.provenance is None else recording.provenance.channel_names
    return dmdt_file(
        cut,
        first,
        quantity=record.quantity,
        unit=_unit(record),
        channels=names or _channels(record),
        recording=recording,
        frame=frame,
        notes=notes,
    )

"""Recordings on disk: list, describe, download, calibrated dm/dt for plots and in full."""

from __future__ import annotations

import io
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Annotated, Any, Literal
from urllib.parse import quote

import numpy as np
from fastapi import APIRouter, Depends, Query, Response
from fastapi.responses import FileResponse
from numpy.typing import NDArray

from drivers.errors import InputError
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.dmdt_bytes import dmdt_file
from platform_daemon.core.recordings.index import Broken, resolve
from platform_daemon.core.recordings.index import list_recordings as recordings_in
from platform_daemon.core.recordings.leftovers import kept_series
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import FrameInfo, Recording
from platform_daemon.core.recordings.recovery import recover_all
from platform_daemon.core.recordings.running import StoredFrame, describe_running, read_frame
from platform_daemon.core.schemas.recordings import (
    DmdtSeries,
    RecordingInfo,
    RecordingLinks,
    RecordingListing,
    RecordingSummary,
    RecoveryReport,
)
from platform_daemon.core.state.errors import IndexUnfinished, StorageError
from platform_daemon.core.web.context import CONFIRMED, Confirmed, Context, Frame, RecordingId, Shared
from platform_daemon.core.web.costs import check_frame, check_sent
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Page, Paged
from platform_daemon.core.web.problems import problems, unreadable
from platform_daemon.core.web.ranged_file import BINARY, RangedFile, ranged
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.features.fit.decimation import min_max_decimate

from .query import RecordingQuery

router = APIRouter(prefix="/recordings", tags=["recordings"], route_class=GuardedRoute)
HDF5, BYTES = "application/x-hdf5", "application/octet-stream"
Points = Annotated[int, Query(ge=2, le=20_000, description="at most so many points per channel")]
Start = Annotated[float, Query(ge=0, le=1e6, description="from, s after the first RX sample")]
First = Annotated[int, Query(ge=0, le=10_000_000, description="list frames from this one on, from 0")]
Listed = Annotated[int | None, Query(ge=0, le=1_000_000, description="list at most so many frames; left out: all")]
Newest = Annotated[bool, Query(description="newest first, by the time in the name; else by name")]
Stop = Annotated[float | None, Query(gt=0, le=1e6, description="to, s; default: the end")]


def opened(identifier: str, context: Shared) -> Recording:
    """The recording of that id.  Raises UnknownRecording, RecordingError."""
    return open_recording(resolve(context.folders.recordings, identifier))


@router.get("", summary="All recordings", responses={**NEXT, **problems(422, 503)})
def list_recordings(
    context: Shared, page: Paged, query: Annotated[RecordingQuery, Depends()], newest: Newest = False
) -> RecordingListing:
    """Every recording, and every file that cannot be read with the reason; by name, page by page.

    Among the latter, on the first page, are shots that could not be put together: POST /recordings/recover does.
    What is looked for is found by the index; one that has just appeared is waited for, for a second at most.
    """
    from platform_daemon.features.trends.indexed import known_entries

    only, folder = query.files(context), context.folders.recordings
    found = recordings_in(
        folder,
        after=page.after or "",
        limit=page.limit,
        only=only,
        newest=newest,
        known=partial(known_entries, folder),
    )
    if found.last is not None:
        page.goes_on_after(found.last)
    known = _known(context, [e.id for e in found.recordings])
    return RecordingListing(
        items=tuple(
            RecordingSummary(**{**asdict(e), "path": e.path.name}, **known.get(e.id, {}), links=_links(e.id))
            for e in found.recordings
        ),
        next=page.next,
        broken=tuple(map(unreadable, (*found.broken, *(_kept(context, page) if only is None else ())))),
    )


def _known(context: Context, identifiers: Sequence[str]) -> dict[str, dict[str, Any]]:
    """What the index says of these recordings; nothing as long as it is being made."""
    from platform_daemon.features.trends.indexed import summaries_of

    try:
        return {name: asdict(found) for name, found in summaries_of(context.folders.recordings, identifiers).items()}
    except (IndexUnfinished, StorageError):  # the list of the files does not depend on it
        return {}


def _kept(context: Context, page: Page) -> Sequence[Broken]:
    """Shots that were never put together, on the first page."""
    return () if page.after else kept_series(context.folders.recordings)


@router.post("/recover", summary="Put kept shots together", responses=problems(415, 422, 507))
def recover_recordings(context: Shared, body: Confirmed = CONFIRMED) -> RecoveryReport:
    """Make recordings of the acknowledged shots that a full disk or a crash has left in single files.

    The daemon does so whenever it starts; series that run are left alone.  `failed`: what is still kept, and why.
    """
    found = recover_all(context.folders.recordings)
    failed = tuple(unreadable(Broken(path.stem, path, error)) for path, error in found.failed)
    return RecoveryReport(recordings=tuple(path.stem for path in found.made), failed=failed)


@router.get("/{identifier}", summary="What a recording holds", responses=problems(404, 422, 423))
def get_recording(identifier: RecordingId, context: Shared, first: First = 0, limit: Listed = None) -> RecordingInfo:
    """What the recording says: sequence, calibration, frames with verdicts, sample, operator.

    `shots` are those from frame `first` on, `limit` of them at most; left out: all.  Of a series that runs, what it
    holds so far: `incomplete` says so, and its frames can be read already.
    """
    listed = range(first, sys.maxsize if limit is None else first + limit)
    running = describe_running(context.folders.recordings, identifier)
    if running is not None:
        shots = tuple(each for each in running.shots if each.frame in listed)
        here = {"id": identifier, "file": f"{identifier}.h5", "links": _links(identifier), "shots": shots}
        return running.model_copy(update=here)
    recording = opened(identifier, context)
    here = {"id": identifier, "file": recording.path.name, "links": _links(identifier)}
    return describe(recording, listed).model_copy(update=here)


def _links(identifier: str) -> RecordingLinks:
    base = f"/recordings/{quote(identifier)}"
    return RecordingLinks(self=base, file=f"{base}/file", dmdt=f"{base}/frames/0/dmdt")


@router.get(
    "/{identifier}/file",
    summary="The file itself",
    response_class=FileResponse,
    responses={
        200: {"content": {HDF5: BINARY}, "description": "HDF5, NeXus, `.mmr`"},
        **ranged({HDF5: BINARY}),
        **problems(404, 422, 423),
    },
)
def download_recording(identifier: RecordingId, context: Shared) -> RangedFile:
    """The whole file (HDF5, NeXus, `.mmr`), or what `Range` asks for of it.

    `Want-Repr-Digest: sha-256=1` has `Repr-Digest` with the SHA-256 of the whole file (RFC 9530).
    """
    path = opened(identifier, context).path
    return RangedFile(path, HDF5, path.name)


@dataclass(frozen=True)
class _Cut:
    """A stretch of one frame: samples (3, n) of `record` from sample `first` on, and what was assumed; recording: the
    file that it is from, of a series that runs that of its shot."""

    identifier: str
    frame: int
    recording: Recording
    info: FrameInfo
    record: RingDownRecord
    samples: NDArray[np.float64]
    first: int
    notes: tuple[str, ...]

    @property
    def channels(self) -> list[str]:
        """World axes, or numbers of the receive channels."""
        return list("xyz") if self.record.quantity == "dmdt" else [str(c) for c in range(len(self.record.samples))]

    @property
    def unit(self) -> Literal["A m^2/s", "V"]:
        """Of the samples."""
        return "A m^2/s" if self.record.quantity == "dmdt" else "V"


@router.get(
    "/{identifier}/frames/{frame}/dmdt",
    summary="Calibrated dm/dt of a frame",
    response_model=DmdtSeries,
    responses={200: {"content": {BYTES: BINARY}}, **problems(404, 422, 423)},
)
def get_dmdt(
    identifier: RecordingId,
    frame: Frame,
    context: Shared,
    format: Annotated[
        Literal["json", "npy", "h5"], Query(description="json is decimated, npy and h5 are full")
    ] = "json",
    points: Points = 2000,
    start_s: Start = 0.0,
    stop_s: Stop = None,
) -> Any:
    """dm/dt = -P^-1 u in A m^2/s, world axes; the RX volts if the recording has no calibration.

    `npy` and `h5` as /dmdt.npy and /dmdt.h5.
    """
    cut = _cut(identifier, frame, context, start_s, stop_s)
    if format == "json":
        return _points(cut, points)
    return _download(cut, "npy", _npy(cut)) if format == "npy" else _download(cut, "h5", _h5(cut))


@router.get(
    "/{identifier}/frames/{frame}/dmdt.npy",
    summary="Calibrated dm/dt of a frame as a numpy file",
    response_class=Response,
    responses={200: {"content": {BYTES: BINARY}, "description": "float64 (3, n)"}, **problems(404, 422, 423)},
)
def get_dmdt_npy(
    identifier: RecordingId, frame: Frame, context: Shared, start_s: Start = 0.0, stop_s: Stop = None
) -> Response:
    """All samples, float64 (3, n), A m^2/s in world axes; volts if the recording has no calibration."""
    cut = _cut(identifier, frame, context, start_s, stop_s)
    return _download(cut, "npy", _npy(cut))


@router.get(
    "/{identifier}/frames/{frame}/dmdt.h5",
    summary="Calibrated dm/dt of a frame as an HDF5 file",
    response_class=Response,
    responses={200: {"content": {BYTES: BINARY}, "description": "HDF5"}, **problems(404, 422, 423)},
)
def get_dmdt_h5(
    identifier: RecordingId, frame: Frame, context: Shared, start_s: Start = 0.0, stop_s: Stop = None
) -> Response:
    """All samples: datasets `dmdt` (3, n), `channel` (3,) and `time` (n,) as dimension scales, units.

    Attributes of the file: the sampling rate and the source (recording, frame, calibration, software).
    """
    cut = _cut(identifier, frame, context, start_s, stop_s)
    return _download(cut, "h5", _h5(cut))


@router.get(
    "/{identifier}/frames/{frame}/dmdt.f32",
    summary="Smallest and largest values of a stretch, for plots",
    response_class=Response,
    responses={200: {"content": {BYTES: BINARY}, "description": "float32 (channels, points, 2)"}, **problems(404, 422)},
)
def get_dmdt_extremes(
    identifier: RecordingId,
    frame: Frame,
    context: Shared,
    points: Points = 2000,
    start_s: Start = 0.0,
    stop_s: Stop = None,
) -> Response:
    """Pairs of minimum and maximum, little-endian float32 (channels, points, 2), each of `Samples-Per-Point` samples.

    Headers say the rest: `Channels`, `Unit`, `Start-S` and `Step-S` (time of the first point, and from point to point).
    """
    cut = _cut(identifier, frame, context, start_s, stop_s)
    size, low, high = min_max_decimate(cut.samples, points)
    rate_hz = cut.record.sampling_rate_hz
    headers = {
        "Channels": ",".join(cut.channels),
        "Unit": cut.unit,
        "Start-S": repr(cut.first / rate_hz),
        "Step-S": repr(size / rate_hz),
        "Samples-Per-Point": str(size),
    }
    pairs = np.stack((low, high), axis=-1).astype("<f4")
    return Response(pairs.tobytes(), media_type=BYTES, headers=headers)


def _cut(identifier: str, frame: int, context: Shared, start_s: float, stop_s: float | None) -> _Cut:
    """Raises UnknownRecording, RecordingError, TooCostly, InputError for a range without samples."""
    recording, info, record, assumed = read_frame(context.folders.recordings, identifier, frame, _calibrated)
    rate = recording.sequence.rate_hz
    samples = record.samples.shape[1]
    first, last = round(start_s * rate), samples if stop_s is None else round(stop_s * rate)
    if not 0 <= first < last <= samples:
        remedy = f"ask for times from 0 to {samples / rate:.6f} s, start_s before stop_s"
        raise InputError("the time range holds no samples of this frame", where="start_s, stop_s", remedy=remedy)
    bare = () if record.quantity == "dmdt" else ("the recording has no calibration: these are volts at the ADC input",)
    return _Cut(identifier, frame, recording, info, record, record.samples[:, first:last], first, (*bare, *assumed))


def _calibrated(stored: StoredFrame) -> tuple[Recording, FrameInfo, RingDownRecord, tuple[str, ...]]:
    """Its file, what that says of it, its samples, and what was assumed.  Raises RecordingError, TooCostly."""
    from platform_daemon.features.fit.calibrated import calibrated_signal

    recording = open_recording(stored.path)
    check_frame(recording)
    volts = recording.rx_volts(stored.frame)
    signal = calibrated_signal(volts, recording.sequence.rate_hz, recording.calibration)
    return recording, recording.frame_info[stored.frame], signal.record, signal.notes


def _points(cut: _Cut, points: int) -> DmdtSeries:
    size, low, high = min_max_decimate(cut.samples, points)
    start = (cut.first + size * np.arange(low.shape[1])) / cut.record.sampling_rate_hz
    assert cut.record.quantity != "angle"
    return DmdtSeries(
        recording=cut.identifier,
        frame=cut.frame,
        quantity=cut.record.quantity,
        unit=cut.unit,
        channels=tuple(cut.channels),
        sampling_rate_hz=cut.record.sampling_rate_hz,
        samples=cut.samples.shape[1],
        samples_per_point=size,
        t_s=start.tolist(),
        minimum=low.tolist(),
        maximum=high.tolist(),
        notes=cut.notes,
    )


def _download(cut: _Cut, suffix: str, body: bytes) -> Response:
    name = f"{cut.identifier}-frame{cut.frame}-{cut.record.quantity}.{suffix}"
    quoted = quote(name)  # a header is latin-1, a name need not be (RFC 6266)
    said = f'filename="{name}"' if quoted == name else f"filename*=UTF-8''{quoted}"
    headers = {"Content-Disposition": f"attachment; {said}"}
    return Response(body, media_type=BYTES, headers=headers)


def _npy(cut: _Cut) -> bytes:
    check_sent(cut.samples.size)
    buffer = io.BytesIO()
    np.save(buffer, np.ascontiguousarray(cut.samples))
    return buffer.getvalue()


def _h5(cut: _Cut) -> bytes:
    check_sent(cut.samples.size)
    said = cut.recording.provenance if cut.record.quantity != "dmdt" else None
    names = () if said is None else said.channel_names
    return dmdt_file(
        cut.samples,
        cut.first,
        quantity=cut.record.quantity,
        unit=cut.unit,
        channels=names or cut.channels,
        recording=cut.recording,
        info=cut.info,
        identifier=cut.identifier,
        frame=cut.frame,
        notes=list(cut.notes),
    )

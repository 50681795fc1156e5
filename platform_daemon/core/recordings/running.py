"""A series that runs: its shots are single files until it is put together, and can be read all the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from drivers.errors import PlatformError, RecordingError
from platform_daemon.core.schemas.recordings import RecordingInfo
from platform_daemon.core.schemas.text import counted
from platform_daemon.core.state.errors import RecordingInUse, UnknownRecording

from .description import describe
from .index import resolve
from .reader import open_recording
from .staging import shot_in, staging_folders, target_of

FoundT = TypeVar("FoundT")
MOST_DESCRIBED = 1000
"""Shots of a running series: each is a file that must be opened."""


@dataclass(frozen=True)
class StoredFrame:
    """A frame that can be read: its file, and its number there."""

    path: Path
    frame: int


def read_frame(folder: Path, identifier: str, frame: int, read: Callable[[StoredFrame], FoundT]) -> FoundT:
    """What `read` makes of a frame of a recording, or of a series that runs, a resumed one too.

    It is read once more where the shots were put together meanwhile.  Raises UnknownRecording, and what `read` raises:
    a frame that does not exist in a recording is for it to refuse.
    """
    found = _stored_frame(folder, identifier, frame)
    try:
        return read(found)
    except (PlatformError, OSError):
        if found.path.exists():
            raise
    return read(_stored_frame(folder, identifier, frame))


def _stored_frame(folder: Path, identifier: str, frame: int) -> StoredFrame:
    """Raises UnknownRecording."""
    for _ in range(2):  # it may be put together between the two looks
        staging = _staging(folder, identifier)
        if staging is not None and frame >= 0 and shot_in(staging, frame + 1).exists():
            return StoredFrame(shot_in(staging, frame + 1), 0)
        try:
            return StoredFrame(resolve(folder, identifier), frame)
        except UnknownRecording as error:
            unknown = error
        shots = _shots(staging)
        if shots:
            unknown = UnknownRecording(
                f"{identifier!r} has {counted(len(shots), 'shot')} so far, and no frame {frame}",
                where=str(folder),
                remedy="wait until that shot is on the disk",
            )
    raise unknown


def describe_running(folder: Path, identifier: str) -> RecordingInfo | None:
    """What a series that runs holds so far; None: there is none of that id, or its recording holds more."""
    shots = _shots(_staging(folder, identifier))
    if not shots or _frames(folder, identifier) > len(shots):  # it is being resumed: they are taken up
        return None
    first = max(0, len(shots) - MOST_DESCRIBED)
    try:
        found = [(k, describe(open_recording(shots[k]))) for k in range(first, len(shots))]
    except RecordingError:
        if all(shot.exists() for shot in shots[first:]):
            raise
        return None  # it has just been put together
    frames = [each.shots[0].model_copy(update={"frame": k}) for k, each in found]
    left = "" if first == 0 else f"; the last {MOST_DESCRIBED} of them are listed here"
    return found[-1][1].model_copy(
        update={
            "size_bytes": sum(each.size_bytes for _, each in found),
            "frames": len(shots),
            "good": sum(each.verdict == "good" for each in frames),
            "incomplete": f"still being measured: {counted(len(shots), 'shot')} so far{left}",
            "start_time": found[0][1].start_time,
            "shots": tuple(frames),
        }
    )


def _frames(folder: Path, identifier: str) -> int:
    """Of the recording of that id; 0: there is none yet, or it cannot be read.  Raises RecordingInUse."""
    try:
        return open_recording(resolve(folder, identifier)).frames
    except RecordingInUse:
        raise
    except (UnknownRecording, RecordingError):
        return 0


def _staging(folder: Path, identifier: str) -> Path | None:
    return next((each for each in staging_folders(folder) if target_of(each).stem == identifier), None)


def _shots(staging: Path | None) -> list[Path]:
    return [] if staging is None else sorted(staging.glob("shot_*.h5"))

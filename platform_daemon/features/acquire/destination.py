"""Where the shots of a series go: to a file of its own, or into the one recording of a procedure."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from platform_daemon.core.recordings.header import FitTable, SeriesHeader, ShotRecord
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.disk_space import check_free_space


class ShotSink(Protocol):
    """Takes the shots of one series, each durable when it is counted."""

    @property
    def shots(self) -> int:
        """Shots of this series on disk."""

    @property
    def frames(self) -> int:
        """Frames of the recording on disk, those of other series in it included."""

    @property
    def target(self) -> Path:
        """The recording that they will be in."""

    @property
    def last_shot(self) -> Path:
        """The file of the last shot on disk, a recording of its own until the series is put together."""

    def shot_file(self, number: int) -> Path:
        """The file of a shot of this series, from 1."""

    @property
    def header(self) -> SeriesHeader:
        """What holds for the next shot."""

    def go_on_with(self, header: SeriesHeader) -> None:
        """Further shots differ in windows or excitation.  Raises InputError."""

    def add_shot(self, shot: ShotRecord) -> int:
        """Store a shot; its number in this series, from 1.  Raises InputError, StorageError."""

    def finish(self, fits: Sequence[FitTable] = ()) -> Path | None:
        """All shots are there, these are their fits; the recording, None without any shot.  Raises StorageError."""


class Destination(Protocol):
    """Where the shots of a series go."""

    @property
    def goes_on(self) -> bool:
        """Shots have been made before in the same recording: the first one waits as long as all others."""

    def check(self, planned_bytes: int, shots: int) -> None:
        """Before anything moves: can the disk take so much?  Raises StorageUnusable."""

    def open(self, header: SeriesHeader, job: str) -> AbstractContextManager[ShotSink]:
        """Begin, once the header is known; job: id of the job.  Raises InputError."""


class OwnFile:
    """A series that is a recording of its own: `target`, or `folder`/ID.h5 of the job's id."""

    goes_on = False

    def __init__(self, target: Path | None, folder: Path, *, overwrite: bool = False) -> None:
        self._target, self._folder, self._overwrite = target, folder, overwrite

    def check(self, planned_bytes: int, shots: int) -> None:
        """See Destination."""
        check_free_space(self._folder if self._target is None else self._target.parent, planned_bytes, shots)

    def open(self, header: SeriesHeader, job: str) -> SeriesWriter:
        """See Destination."""
        return SeriesWriter.create(self._target or self._folder / f"{job}.h5", header, overwrite=self._overwrite)


class SameFile:
    """A series that was interrupted, and is resumed in its own recording `target`."""

    goes_on = True

    def __init__(self, target: Path) -> None:
        self._target = target

    def check(self, planned_bytes: int, shots: int) -> None:
        """See Destination."""
        check_free_space(self._target.parent, planned_bytes, shots)

    def open(self, header: SeriesHeader, job: str) -> SeriesWriter:
        """See Destination.  Raises InputError also if what it was measured with has changed."""
        return SeriesWriter.go_on(self._target, header)

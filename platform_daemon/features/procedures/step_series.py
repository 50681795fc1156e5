"""The one recording of a procedure: each step's series adds its shots to it, and it is put together at the end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from platform_daemon.core.recordings.fit_joining import joined_fits
from platform_daemon.core.recordings.header import FitTable, SeriesHeader, ShotRecord
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.disk_space import check_free_space

from .schema import ProcedureSummary


class StepSeries:
    """A destination for series after series.  The folder of shots is held from the first to the last.

    title: of the recording; outline: what it will hold at most.
    """

    def __init__(self, target: Path, title: str, outline: ProcedureSummary, *, overwrite: bool = False) -> None:
        self.target, self._title, self._outline, self._overwrite = target, title, outline, overwrite
        self._writer: SeriesWriter | None = None
        self._fits: list[tuple[int, FitTable]] = []

    @property
    def shots(self) -> int:
        """Shots on disk, of all steps."""
        return 0 if self._writer is None else self._writer.shots

    @property
    def last_shot(self) -> Path:
        """The file of the last shot on disk; there must be one."""
        assert self._writer is not None
        return self._writer.last_shot

    @property
    def goes_on(self) -> bool:
        """See Destination."""
        return self.shots > 0

    def file(self, frame: int) -> Path:
        """See ShotFiles."""
        assert self._writer is not None
        return self._writer.shot_file(frame + 1)

    def usable(self, frame: int) -> bool:
        """See ShotFiles."""
        info = open_recording(self.file(frame)).frame_info[0]
        return not info.blank and info.verdict == "good"

    def blank(self, frame: int) -> bool:
        """See ShotFiles."""
        info = open_recording(self.file(frame)).frame_info[0]
        return info.blank and info.verdict == "good"

    def check(self, planned_bytes: int, shots: int) -> None:
        """See Destination."""
        check_free_space(self.target.parent, planned_bytes, shots)

    @contextmanager
    def open(self, header: SeriesHeader, job: str) -> Iterator[StepSink]:
        """See Destination."""
        whole = replace(header, title=self._title, planned_shots=self._outline.shots or None)
        if self._writer is None:
            self._writer = SeriesWriter.create(self.target, whole, self._overwrite, self._outline.disk_bytes)
        else:
            self._writer.go_on_with(replace(whole, start_time=self._writer.header.start_time))
        yield StepSink(self._writer, self._fits)

    def finish(self, incomplete: str | None) -> Path | None:
        """Put the recording together; None without a single shot.  See SeriesWriter.finish."""
        if self._writer is None:
            return None
        return self._writer.finish(joined_fits(self._fits, self._writer.shots), incomplete)

    def close(self) -> None:
        """Let go; shots that are not put together stay for `recover`.  Idempotent."""
        if self._writer is not None:
            self._writer.close()


class StepSink:
    """See ShotSink: the shots of one step, and where its fits are kept until the recording is put together."""

    def __init__(self, writer: SeriesWriter, fits: list[tuple[int, FitTable]]) -> None:
        self._writer, self._fits, self._before = writer, fits, writer.shots

    @property
    def shots(self) -> int:
        """See ShotSink."""
        return self._writer.shots - self._before

    @property
    def frames(self) -> int:
        """See ShotSink."""
        return self._writer.shots

    @property
    def target(self) -> Path:
        """See ShotSink."""
        return self._writer.target

    @property
    def last_shot(self) -> Path:
        """See ShotSink."""
        return self._writer.last_shot

    @property
    def header(self) -> SeriesHeader:
        """See ShotSink."""
        return self._writer.header

    def shot_file(self, number: int) -> Path:
        """See ShotSink."""
        return self._writer.shot_file(self._before + number)

    def go_on_with(self, header: SeriesHeader) -> None:
        """See ShotSink."""
        self._writer.go_on_with(header)

    def add_shot(self, shot: ShotRecord) -> int:
        """See ShotSink."""
        return self._writer.add_shot(shot) - self._before

    def finish(self, fits: Sequence[FitTable] = ()) -> Path | None:
        """See ShotSink; the recording appears when its procedure ends."""
        self._fits.extend((self._before, table) for table in fits if self.shots)
        return self.target if self.shots else None

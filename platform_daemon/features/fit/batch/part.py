"""What a worker does: open a file, fit some of its frames, say what came out."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.features.fit.fit import FittedFrame, fit_stored_frame, measurement_report
from platform_daemon.features.fit.fit_request import FitRequest, FitSettings
from platform_daemon.features.fit.measurement import Measurement, open_for_fit, taken_frames


@dataclass(frozen=True)
class InputFile:
    """A file: its path, and its content where workers cannot read that path."""

    path: Path
    content: bytes | None = None


@contextmanager
def opened(source: InputFile, settings: FitSettings) -> Iterator[tuple[Measurement, FitRequest]]:
    """The file under the batch's settings, and what to ask of it.  Raises InputError."""
    if source.content is None:
        yield open_for_fit(source.path, settings)
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, source.path.name)
        copy.write_bytes(source.content)
        yield open_for_fit(copy, settings)


def count_frames(source: InputFile, settings: FitSettings) -> int:
    """Frames of a file that can be fitted as requested.  Raises InputError."""
    with opened(source, settings) as (measurement, _):
        return len(taken_frames(measurement, settings.frames, settings.step)[0])


def fit_part(source: InputFile, settings: FitSettings, first: int, last: int) -> list[FittedFrame]:
    """The chosen frames number first .. last-1.  Raises InputError."""
    with opened(source, settings) as (measurement, ask):
        part = taken_frames(measurement, settings.frames, settings.step)[0][first:last]
        return [fit_stored_frame(measurement, k, ask, derived=settings.derived) for k in part]


def put_together(source: InputFile, settings: FitSettings, frames: list[FittedFrame]) -> FitReport:
    """The report of a file from all its frames.  Raises InputError if no frame could be read."""
    with opened(source, settings) as (measurement, ask):
        report = measurement_report(measurement, ask, frames, derived=settings.derived)
        return report.model_copy(update={"file": str(source.path)})


def fit_whole(source: InputFile, settings: FitSettings) -> FitReport:
    """The report of a whole file.  Raises InputError."""
    return put_together(source, settings, fit_part(source, settings, 0, count_frames(source, settings)))

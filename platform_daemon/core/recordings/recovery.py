"""Finds what a crash left behind and puts it together."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import structlog

from drivers.errors import PlatformError, RecordingError
from platform_daemon.core.state.errors import RecordingInUse, RecordingUnfinished

from .assembly import assemble, header_of
from .continuation import holds_all_of
from .leftovers import not_assembled
from .reader import open_recording
from .staging import Staging, abandoned_series

_log = structlog.get_logger(__name__)
PUT_TOGETHER = "put together from the shots of a series whose program was killed, crashed or lost its power"


@dataclass(frozen=True)
class Recovered:
    """Series files that were made, and what kept others from being made, by the path they would have."""

    made: tuple[Path, ...]
    failed: tuple[tuple[Path, PlatformError], ...]


def recover(folder: Path | str, spare: Path | None = None) -> list[Path]:
    """See recover_all; what failed is logged."""
    return list(recover_all(folder, spare).made)


def recover_all(folder: Path | str, spare: Path | None = None) -> Recovered:
    """Put together every series in `folder` whose writer died.

    Series that are being written are left alone.  A file that exists is never replaced: the recovered one is then
    called `<name>.recovered.h5`, and so is that of `spare`, which is about to be written; but one that was being
    resumed gets the shots that came.  Never raises for one bad series: it is logged, stays as it is, and is tried again
    at the next start.
    """
    made: list[Path] = []
    failed: list[tuple[Path, PlatformError]] = []
    for staging in abandoned_series(Path(folder)):
        try:
            target = recover_series(staging, spare_target=staging.target == spare)
        except (PlatformError, OSError) as error:
            staging.release()
            _log.error("series_not_recovered", folder=str(staging.folder), error=str(error))
            why = error.why if isinstance(error, PlatformError) else str(error)
            failed.append((staging.target, not_assembled(staging.folder, len(staging.shots()), why)))
            continue
        if target is not None:
            _log.warning("series_recovered", path=str(target), what=PUT_TOGETHER)
            made.append(target)
    return Recovered(tuple(made), tuple(failed))


def recover_series(staging: Staging, spare_target: bool = False) -> Path | None:
    """Put one leftover together and remove its folder; None if there was nothing to keep.

    spare_target: leave the series' own name free.  Raises StorageError; everything stays in place then.
    """
    usable, broken = _sorted_out(staging.shots())
    made = None
    if usable:
        names = _names(staging.target, spare_target)
        target = next(path for path in names if not path.exists() or _is_of(path, usable))
        if not target.exists() or not _is_assembled(target, usable):
            assemble(usable, staging.part, target, unreadable=len(broken))
            made = target
    for shot in broken:
        os.replace(shot, staging.target.with_name(f"{staging.target.name}.{shot.stem}.unreadable"))
    staging.remove()
    return made


def _sorted_out(shots: list[Path]) -> tuple[list[Path], list[Path]]:
    usable, broken = [], []
    for shot in shots:
        try:
            recording = open_recording(shot)
            recording.frame_volts(0)
            header_of(recording)
            usable.append(shot)
        except RecordingUnfinished:  # nobody writes it: the lock of the folder was free
            broken.append(shot)
        except RecordingInUse:  # as by a viewer: it is not lost, and taken up at the next start
            raise
        except RecordingError:
            broken.append(shot)
    return usable, broken


def _is_assembled(target: Path, shots: list[Path]) -> bool:
    """Whether the crash came after the rename: `target` is this very series and has all the shots."""
    try:
        found = open_recording(target)
        return header_of(found)[1] == header_of(open_recording(shots[0]))[1] and found.frames >= len(shots)
    except RecordingInUse:
        raise
    except RecordingError:
        return False


def _is_of(target: Path, shots: list[Path]) -> bool:
    """Whether `target` is this series: assembled, or being resumed at the crash, with no shot missing here."""
    try:
        return _is_assembled(target, shots) or holds_all_of(shots, target)
    except RecordingInUse:
        raise
    except RecordingError:
        return False


def _names(target: Path, spare_target: bool) -> Iterator[Path]:
    if not spare_target:
        yield target
    yield target.with_name(f"{target.stem}.recovered{target.suffix}")
    yield from (target.with_name(f"{target.stem}.recovered-{n}{target.suffix}") for n in itertools.count(2))

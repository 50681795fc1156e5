"""Accepted changes of specimens: from the accepted moment on the charts of a specimen restart."""

from __future__ import annotations

import fcntl
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.state.durable import write_file
from platform_daemon.core.state.errors import StorageError

from .schema import Baseline, BaselineRequest, Baselines

BASELINES, LOCK = ".baselines.json", ".baselines.lock"
"""In the folder of the recordings: names that no recording has."""


def baseline_of(folder: Path, specimen: str) -> Baseline | None:
    """What was accepted last; None: nothing yet.  Raises StorageError for a file that is damaged."""
    return _read(folder).root.get(specimen)


def accept(folder: Path, specimen: str, request: BaselineRequest) -> Baseline:
    """Restart the charts of a specimen at its next recording, or from `since` on.  Raises InputError, StorageError."""
    specimen = same_name(specimen)
    now = datetime.now(UTC)
    since = _after_newest(folder, specimen, now) if request.since is None else in_utc(request.since, "since")
    if request.since is not None and since > now:
        remedy = "name a time that has passed, or leave it out for now"
        raise InputError(f"{request.since} is still to come", where="since", remedy=remedy)
    made = Baseline(since=_text(since), by=request.by.strip(), reason=request.reason.strip(), accepted=_text(now))
    try:
        with (folder / LOCK).open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # several programs may accept at once
            kept = Baselines({**_read(folder).root, specimen: made})
            write_file(folder / BASELINES, to_json(kept, indent=1).encode())
    except OSError as error:
        what, remedy = "the baseline cannot be kept", "free or repair the disk, and accept again"
        raise StorageError(what, where=str(folder / BASELINES), why=str(error), remedy=remedy) from None
    return made


def _after_newest(folder: Path, specimen: str, now: datetime) -> datetime:
    """When its newest recording had begun, by the clock of the platform: that of a simulated one stands still while
    nothing runs, and what is recorded after now may say that it was before.  `now` if there is none.

    Raises StorageError.
    """
    with closing(open_index(folder)) as index:
        found = index.recordings(specimen)
    return in_utc(found[-1].begun, "begun") + timedelta(milliseconds=1) if found else now


def in_utc(text: str, where: str) -> datetime:
    """A time of ISO 8601; UTC where it names no zone.  Raises InputError."""
    try:
        found = datetime.fromisoformat(text)
        return (found if found.tzinfo else found.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):  # the latter: in UTC it is before the year 1, or after 9999
        remedy = "write it as 2026-11-21 or 2026-11-21T18:00:00+01:00"
        raise InputError(f"{text!r} is no time of ISO 8601", where=where, remedy=remedy) from None


def _text(at: datetime) -> str:
    return at.isoformat(timespec="milliseconds")


def _read(folder: Path) -> Baselines:
    try:
        return Baselines.model_validate_json((folder / BASELINES).read_bytes())
    except FileNotFoundError:
        return Baselines({})
    except (OSError, ValueError) as error:
        what = "the accepted states of specimens cannot be read"
        remedy = "correct the file, or delete it and accept the state again"
        why = str(error).splitlines()[0]
        raise StorageError(what, where=str(folder / BASELINES), why=why, remedy=remedy) from None

"""The recordings of a schedule, by its ledger."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.index import recording_files
from platform_daemon.features.schedules.contract import ScheduleService
from platform_daemon.features.schedules.named import named_id
from platform_daemon.features.schedules.schedules import UnknownSchedule
from platform_daemon.features.schedules.schema import LedgerRow
from platform_daemon.features.trends.indexed import between

_ROWS = 1000  # of a page of the ledger


@dataclass(frozen=True)
class Series:
    """What a schedule has recorded.

    Attributes:
        schedule: its name or id, as it was given.
        files: its recordings in the order of their starts.
        missing: how many recordings of its ledger are not in the folder any more.
    """

    schedule: str
    files: tuple[Path, ...]
    missing: int


def series_of(
    schedules: ScheduleService, given: str, recordings: Path, since: str | None = None, until: str | None = None
) -> Series:
    """The recordings of a schedule that were started between two times, ISO 8601, UTC where they name no zone.

    given: name or id of the schedule; recordings: folder.  Raises UnknownSchedule that says which there are, InputError
    for a name that several have, a time that is none, and a schedule that has recorded nothing then, StorageError.
    """
    begin, end = between(since, until)
    rows = [row for row in _rows(schedules, given) if row.recording is not None and _is_between(row, begin, end)]
    if not rows:
        span = "" if since is None and until is None else f" between {since or 'its begin'} and {until or 'now'}"
        remedy = "`platform-daemon schedule ledger` shows what became of its starts; only series have recordings"
        raise InputError(f"the schedule has recorded nothing{span}", where=given, remedy=remedy)
    there: dict[str, Path] = {}
    for path in recording_files(recordings):  # as everywhere, the first of those that share an id has it
        there.setdefault(path.stem, path)
    names = dict.fromkeys(row.recording for row in rows if row.recording is not None)
    files = tuple(there[name] for name in names if name in there)
    if not files:
        what = "none of the recordings of the schedule is there"
        why, remedy = f"{len(names)} are not in {recordings}", "bring them back, or record others"
        raise InputError(what, where=given, why=why, remedy=remedy)
    return Series(given, files, len(names) - len(files))


def _is_between(row: LedgerRow, begin: str | None, end: str | None) -> bool:
    at = datetime.fromisoformat(row.started or row.due)
    return (begin is None or at >= datetime.fromisoformat(begin)) and (end is None or at <= datetime.fromisoformat(end))


def _rows(schedules: ScheduleService, given: str) -> list[LedgerRow]:
    identifier = named_id(schedules, given)
    found: list[LedgerRow] = []
    try:
        page = schedules.page(identifier, 0, _ROWS)
        found += page.items
        while page.next is not None:
            page = schedules.page(identifier, found[-1].number, _ROWS)
            found += page.items
    except UnknownSchedule:
        known = [each.id if each.request is None else each.request.name for each in schedules.list()]
        why, remedy = f"there are: {', '.join(known) or 'none yet'}", "name one of them"
        raise UnknownSchedule(f"no schedule {given!r}", where="schedule", why=why, remedy=remedy) from None
    return found

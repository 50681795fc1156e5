"""Trends of the recordings in a folder, by its index."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from datetime import date, datetime, time
from pathlib import Path

import structlog

from drivers.errors import InputError
from platform_daemon.core.recordings.index import Entry
from platform_daemon.core.recordings.indexed import IndexedSpecimen, IndexedSummary, IndexUpdate, Wanted
from platform_daemon.core.recordings.recording_index import RecordingIndex, open_index
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.state.errors import StorageError

from .baseline import baseline_of, in_utc
from .look import look_at_recording
from .schema import TrendReport
from .steps import of_step
from .trend import POINTS_TO_FALSE_ALARM, specimen_trend
from .undeclared import undeclared_temperature

log = structlog.get_logger()


def update_index(
    folder: Path, done: Callable[[int, int], None] = lambda n, of: None, *, rebuild: bool = False
) -> tuple[IndexUpdate, dict[str, str]]:
    """What was looked at, and the files of the folder that cannot be read, by id, each with the reason.

    done: called with the number of files done and of all; rebuild: read all of them, as for a damaged index.  Raises
    StorageError.
    """
    with closing(open_index(folder, rebuild=rebuild)) as index:
        try:
            found = index.update(look_at_recording, done)
            return found, dict(index.broken())
        except StorageError as error:
            if rebuild or not index.damaged:
                raise
            log.warning("index_made_anew", error=str(error))
    return update_index(folder, done, rebuild=True)


def find_recordings(folder: Path, wanted: Wanted) -> tuple[str, ...]:
    """Names of the files of what is looked for, by the index; times in any zone.  Raises InputError, StorageError."""
    since, until = between(wanted.since, wanted.until)
    name = None if wanted.specimen is None else same_name(wanted.specimen)
    in_utc = replace(wanted, specimen=name, since=since, until=until)
    with closing(open_index(folder)) as index:
        return tuple(index.find(in_utc))


def known_entries(folder: Path, paths: Sequence[Path]) -> dict[Path, Entry]:
    """What a list says of those of these files that the index knows as they are; the others must be opened."""
    try:
        with closing(open_index(folder)) as index:
            return index.entries(paths)
    except StorageError as error:  # the list of the files does not depend on it
        log.warning("index_not_used", error=str(error))
        return {}


def summaries_of(folder: Path, identifiers: Sequence[str]) -> dict[str, IndexedSummary]:
    """What the index holds of these recordings, by id.  Raises StorageError, IndexUnfinished."""
    with closing(open_index(folder)) as index:
        return index.summaries(identifiers)


def indexed_specimens(folder: Path) -> tuple[str, ...]:
    """Names of all specimens with shots that were fitted.  Raises StorageError."""
    with closing(open_index(folder)) as index:
        return tuple(index.specimens())


def indexed_trend(
    folder: Path,
    specimen: str,
    since: str | None = None,
    until: str | None = None,
    points_to_false_alarm: float = POINTS_TO_FALSE_ALARM,
    step: str | None = None,
    newest: int | None = None,
    *,
    uncertainty: bool = False,
) -> TrendReport:
    """The trend of a specimen between two times, ISO 8601; since None: from where it was accepted as it is.

    step: of procedures, see `of_step`; None: the last one.  newest: points that are listed at most, None: all; the
    charts are those of all of them.  uncertainty: U of every value, which takes some fits for each calibration.  Raises
    UnknownSpecimen, InputError, StorageError, RecordingError.
    """
    specimen = same_name(specimen)
    begin, end = between(since, until)
    accepted = baseline_of(folder, specimen) if since is None else None
    if accepted is not None:
        begin = _time(accepted.since, "since")
    with closing(open_index(folder)) as index:
        check_known(index, specimen)
        found = index.recordings(specimen, begin or "", end or "\uffff")
        without: list[str] = []
        if step is not None:
            found, without = of_step(folder, index, found, step)
    report = specimen_trend(specimen, found, points_to_false_alarm, step, newest)
    if uncertainty:
        from .uncertainty import with_uncertainty  # fits, which nothing else here needs

        report = with_uncertainty(report, folder, found, step)
    if told := undeclared_temperature(report, found, folder):
        report = report.model_copy(update={"notes": (*report.notes, *told)})
    if without:
        note = f"left out, because they have no step {step!r}: {', '.join(without)}"
        report = report.model_copy(update={"notes": (*report.notes, note)})
    if accepted is None:
        return report
    note = f"restarted at {accepted.since} by {accepted.by}: {accepted.reason}"
    return report.model_copy(update={"notes": (note, *report.notes)})


def indexed_specimen(folder: Path, specimen: str) -> IndexedSpecimen:
    """What is known of its recordings with on-line fits.  Raises UnknownSpecimen, StorageError."""
    specimen = same_name(specimen)
    with closing(open_index(folder)) as index:
        found = index.specimen(specimen)
        if found is None:
            raise _unknown(specimen, index.specimens())
        return found


def check_known(index: RecordingIndex, specimen: str) -> None:
    """Raises UnknownSpecimen."""
    specimens = index.specimens()
    if specimen not in specimens:
        raise _unknown(specimen, specimens)


def _unknown(specimen: str, known: Sequence[str]) -> UnknownSpecimen:
    why = f"those with on-line fits: {', '.join(known[:20]) or 'none yet'}"
    remedy = "name one of them; `sample` of an acquisition is the name of the specimen, else its resonator's"
    return UnknownSpecimen(f"no recording is of {specimen!r}", where="specimen", why=why, remedy=remedy)


class UnknownSpecimen(InputError):
    """No recording is of that specimen."""

    title = "Unknown specimen"
    http_status = 404


def between(since: str | None, until: str | None) -> tuple[str | None, str | None]:
    """Two times of ISO 8601, both in UTC.  Raises InputError for what is no time, and for an end before the begin."""
    begin, end = _time(since, "since"), _until(until)
    if begin is not None and end is not None and end < begin:
        remedy = "name a time after `since`, or leave one of them out"
        raise InputError(f"{until} is before {since}, where it begins", where="until", remedy=remedy)
    return begin, end


def _until(text: str | None) -> str | None:
    """The last moment of a day where that alone is named.  Raises InputError."""
    try:
        day = None if text is None else date.fromisoformat(text)
    except ValueError:
        return _time(text, "until")
    return None if day is None else _time(datetime.combine(day, time.max).isoformat(), "until")


def _time(text: str | None, where: str) -> str | None:
    """In UTC, as the index keeps it.  Raises InputError."""
    return None if text is None else in_utc(text, where).isoformat(timespec="milliseconds")

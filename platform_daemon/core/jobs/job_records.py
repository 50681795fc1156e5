"""Records of jobs in the state of the daemon, so that an id that was given to a client answers after a restart.

A job that was running when the daemon died comes back as failed, with the reason and where its shots are.  A job that
waited for the hardware waits on; all other jobs that waited come back as failed.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

import psutil
import structlog

from drivers import errors
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.jobs import AnyJobRecord, JobState, JobTimes
from platform_daemon.core.schemas.problems import ErrorRecord
from platform_daemon.core.state.database import DamagedDatabase, Database
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.flag_file import FlagFile
from platform_daemon.core.state.state_file import STATE_SCHEMA, UPSERT_JOB

from .jobs import AnyJob, Job
from .kinds import record_from_json, record_type

log = structlog.get_logger()
_LOCKS = 32  # records that are made at the same time
_FIELDS = ("kind", "request", "total", "unit", "state", "done", "result", "warnings")


class JobRecords:
    """The records of jobs in the file at `path`; None: nothing is kept, as on the one-shot command line.

    The file is opened by the first method that needs it.  All methods raise StorageError where it cannot be read or
    written, unless they say otherwise.  For any number of threads.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._last_sign = _last_sign(path)
        self._opening = threading.Lock()
        self._file: Database | None = None
        self._locks = [threading.Lock() for _ in range(_LOCKS)]

    def save(self, job: AnyJob) -> None:
        """Write the job as it is now; it is on the disk on return."""
        if self._path is None:
            return
        with self._locks[hash(job.identifier) % _LOCKS]:  # else an older record might be written after a newer one
            record = record_of(job)
            values = job.identifier, str(record.state), to_json(record, indent=1, allow_nan=True)
            self._database().execute(UPSERT_JOB, values)
        self._withdrawn(job.identifier).clear()

    def withdraw(self, identifier: str) -> None:
        """Note that a job which waits in its record must not begin, where the disk is too full for a new record.

        The note is a file without content; the next `save` of the job deletes it.
        """
        if self._path is not None:
            self._withdrawn(identifier).set()

    def check(self) -> None:
        """Read the parts of the file that every new record needs, for the start of a daemon.  Raises DamagedDatabase.

        Records that have grown to gigabytes are not read through.  A disk that refuses is logged: without a file that
        can be read the daemon still switches outputs off.
        """
        try:
            self._states(None)
            self.has("")
            if self._path is not None:
                self._database().rows("SELECT max(rowid) FROM jobs")
        except DamagedDatabase:
            raise
        except StorageError as error:
            log.error("job_records_unreadable", error=str(error))

    @property
    def kept(self) -> bool:
        """Whether anything is kept."""
        return self._path is not None

    def has(self, identifier: str) -> bool:
        """Whether there is a record of that job."""
        if self._path is None:
            return False
        return bool(self._database().rows("SELECT 1 FROM jobs WHERE id = ?", (identifier,)))

    def names(self, kinds: frozenset[str] | None) -> list[str]:
        """Ids of all jobs of these kinds (None: of all kinds), oldest first, to the second."""
        return [identifier for identifier, _ in self._states(kinds)]

    def ids_in(self, states: Collection[JobState]) -> set[str]:
        """Ids of the jobs whose records are in one of these states."""
        if self._path is None:
            return set()
        query = f"SELECT id FROM jobs WHERE state IN ({', '.join('?' * len(states))})"
        return {identifier for (identifier,) in self._database().rows(query, tuple(map(str, states)))}

    def one(self, identifier: str) -> AnyJob:
        """A job that was saved.  Raises ValueError if its record is missing, damaged or withdrawn."""
        if self._withdrawn(identifier).is_set:
            raise ValueError("it was cancelled while the disk was full")
        found = self._database().rows("SELECT record FROM jobs WHERE id = ?", (identifier,))
        if not found:
            raise ValueError("it has no record")
        return _job(record_from_json(found[0][0]))

    def load(
        self,
        kinds: frozenset[str] | None = None,
        waiting: frozenset[str] = frozenset(),
        cut_off: Callable[[AnyJob], None] = lambda job: None,
        most: int | None = None,
    ) -> list[AnyJob]:
        """Jobs of earlier runs, oldest first; those that were cut off have failed, and are saved so.

        Args:
            kinds: of these jobs; None: of all.
            waiting: kinds of which jobs that had not begun stay as they were.
            cut_off: is called with each job that was cut off.
            most: so many of the newest, and all that had not ended; None: all.

        Records that cannot be read are logged and left out, and so is a disk that refuses: this method never raises.
        """
        try:
            states = self._states(kinds)
        except StorageError as error:
            log.error("job_records_unreadable", error=str(error))
            return []
        oldest = 0 if most is None else max(len(states) - most, 0)
        wanted = [name for k, (name, state) in enumerate(states) if k >= oldest or not _is_final(state)]
        found = []
        for name in wanted:
            try:
                found.append(self.one(name))
            except (StorageError, ValueError) as error:
                log.error("job_record_unreadable", job=name, error=str(error))
        for job in found:
            waits = job.state is JobState.QUEUED and job.kind in waiting and job.within is None
            if not job.state.final and not waits:
                self._end(job)
                cut_off(job)
        return sorted(found, key=lambda job: job.created.isoformat() if job.created else "")

    def _end(self, job: AnyJob) -> None:
        job.end(JobState.FAILED, cut_off_error(job, self._last_sign))
        try:
            self.save(job)
        except StorageError as error:  # the next start finds it cut off again
            log.error("job_not_saved", job=job.identifier, error=str(error))

    def _states(self, kinds: frozenset[str] | None) -> list[tuple[str, str]]:
        """Id and state of jobs, oldest first."""
        if self._path is None:
            return []
        found = self._database().rows("SELECT id, state FROM jobs ORDER BY id")
        chosen = [row for row in found if kinds is None or row[0].partition("-")[0] in kinds]
        return sorted(chosen, key=lambda row: second_of(row[0]))

    def _database(self) -> Database:
        assert self._path is not None
        with self._opening:
            if self._file is None:
                self._file = Database(self._path, STATE_SCHEMA)
            return self._file

    def _withdrawn(self, identifier: str) -> FlagFile:
        assert self._path is not None
        return FlagFile(self._path.with_name(f"{identifier}.withdrawn"))


def _is_final(state: str) -> bool:
    """Whether a job in that state has ended; False also for a state of another version."""
    try:
        return JobState(state).final
    except ValueError:
        return False


def second_of(identifier: str) -> str:
    """When a job was submitted, as its id says."""
    return identifier.partition("-")[2].partition("-")[0]


def cut_off_error(job: AnyJob, how: str) -> errors.PlatformError:
    """The error of a job whose daemon ended without being told to; how: in words, with the time."""
    again = "ask again"
    kind = feature_of(job.kind).kind
    if kind.resumable and job.within is None:
        again = f"have the missing shots made (POST /{kind.plural}/{job.identifier}/resume), or submit a new {job.kind}"
    return errors.PlatformError(
        f"the daemon ended while this {job.kind} was {job.state}",
        why=f"{how}; a restart never switches outputs on by itself",
        remedy=f"{again}; shots that were stored are among the recordings, under this id",
    )


def _last_sign(path: Path | None) -> str:
    """When the daemon that worked before with the state at `path` was seen last, and what may have ended it."""
    times_s = []
    for pattern in ("*.sqlite*", "*.db*"):  # state, events and schedules, with what SQLite keeps of them in other files
        for file in () if path is None else path.parent.glob(pattern):
            with suppress(OSError):
                times_s.append(file.stat().st_mtime)
    if not times_s:
        return "when is not known"
    last_s, booted_s = max(times_s), psutil.boot_time()
    last, booted = (datetime.fromtimestamp(t, UTC).isoformat(timespec="seconds") for t in (last_s, booted_s))
    if booted_s > last_s:
        how = f"the computer was started again at {booted}, after a power failure, a crash or a shutdown"
    else:
        how = "its process was killed or crashed"
    return f"its last sign of life is of {last}; {how}"


def record_of(job: AnyJob) -> AnyJobRecord:
    """The record of a job as it is now."""
    times = JobTimes(created=iso(job.created), started=iso(job.started), finished=iso(job.finished))
    error = None if job.error is None else _error_record(job.error)
    names = (*_FIELDS, "within", "place", "arrival")
    paused = {"paused": True} if job.state is JobState.QUEUED and job.pause_requested.is_set() else {}
    values = {"id": job.identifier, "clock": job.platform_clock, **{name: getattr(job, name) for name in names}}
    return record_type(job.kind).model_validate({**values, **paused, "times": times, "error": error})


def _job(record: AnyJobRecord) -> AnyJob:
    job: AnyJob = Job(
        record.kind,
        record.request,
        record.result,
        record.total,
        record.unit,
        identifier=record.id,
        state=record.state,
        phase=str(record.state),
        done=record.done,
        warnings=list(record.warnings),
        within=record.within,
        place=record.place,
        arrival=record.arrival,
        platform_clock=record.clock,
    )
    job.created, job.started, job.finished = (
        None if text is None else datetime.fromisoformat(text)
        for text in (record.times.created, record.times.started, record.times.finished)
    )
    if record.error is not None:
        job.error = _error(record.error)
    if record.paused:
        job.pause_requested.set()
    if job.state.final:
        job.ended.set()
    return job


def _error_record(error: Exception) -> ErrorRecord:
    if not isinstance(error, errors.PlatformError):
        error = errors.PlatformError(f"unexpected {type(error).__name__}", why=str(error))
    return ErrorRecord(title=error.title, what=error.what, where=error.where, why=error.why, remedy=error.remedy)


def _error(record: ErrorRecord) -> errors.PlatformError:
    error = errors.PlatformError(record.what, where=record.where, why=record.why, remedy=record.remedy)
    error.title = record.title
    return error


def iso(when: datetime | None) -> str | None:
    """A time in ISO 8601, or None."""
    return None if when is None else when.isoformat()

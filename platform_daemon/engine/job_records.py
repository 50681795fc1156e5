"""Jobs on disk, so that an id that was given out still answers after a restart.

A job that was running when the daemon died comes back as failed: a client that asks learns what happened and where its
shots are.  One that waited for the hardware waits on; all others that waited are failed.
"""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import structlog

from drivers import errors
from platform_daemon.schemas import AnyJobRecord, ErrorRecord, JobState, JobTimes, StoredJob, to_json
from platform_daemon.store import StorageError, sync, write_file

from .jobs import AnyJob, Job

log = structlog.get_logger()
_HEAD = 1 << 14
"""Bytes at the beginning of a record: what was asked for, and the state; what came out may be a thousand times that."""
_STATE = re.compile(rb'^ "state": "(\w+)"', re.MULTILINE)  # of the record itself: other keys are indented by more


_AT_ONCE = 32  # records that are written at the same time
_AS_THEY_ARE = ("kind", "identifier", "request", "total", "unit", "state", "done", "result", "warnings")


class JobRecords:
    """One JSON file per job in `folder`; None: nothing is kept (the one-shot command line)."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._locks = [threading.Lock() for _ in range(_AT_ONCE)]

    def save(self, job: AnyJob) -> None:
        """Write the job as it is now.  Raises StorageError."""
        if self._folder is not None:
            with self._lock(job.identifier):  # else what was read before might be written after what is newer
                record = to_json(record_of(job), indent=1, allow_nan=True)
                write_file(self._folder / f"{job.identifier}.json", record.encode())

    def empty(self, identifier: str) -> None:
        """Leave nothing of that record but its name, which needs no room on the disk.  Raises OSError."""
        if self._folder is not None:
            path = self._folder / f"{identifier}.json"
            with self._lock(identifier):
                os.truncate(path, 0)
                sync(path)

    def _lock(self, identifier: str) -> threading.Lock:
        return self._locks[hash(identifier) % _AT_ONCE]

    @property
    def kept(self) -> bool:
        """Is anything kept?"""
        return self._folder is not None

    def has(self, identifier: str) -> bool:
        """Is there a record of that job?"""
        return self._folder is not None and (self._folder / f"{identifier}.json").exists()

    def names(self, kinds: frozenset[str] | None) -> list[str]:
        """Ids of all jobs of these kinds (None: of all) that were saved, oldest first, to the second."""
        found = os.listdir(self._folder) if self._folder is not None else []
        names = [n.removesuffix(".json") for n in found if n.endswith(".json")]  # parts end with another word
        return sorted((n for n in names if kinds is None or n.partition("-")[0] in kinds), key=second_of)

    def one(self, identifier: str) -> AnyJob:
        """A job that was saved.  Raises OSError, ValueError."""
        assert self._folder is not None
        return _job(StoredJob.model_validate_json((self._folder / f"{identifier}.json").read_text()).root)

    def load(
        self,
        kinds: frozenset[str] | None = None,
        waiting: frozenset[str] = frozenset(),
        cut_off: Callable[[AnyJob], None] = lambda job: None,
        most: int | None = None,
    ) -> list[AnyJob]:
        """Jobs of earlier runs of these kinds (None: of all), oldest first; those cut off are failed and saved so.

        waiting: kinds of which those that had not begun are as they were; cut_off: is told of those that were; most: so
        many of the newest, and all that had not ended, None: all.  Bad files are logged, and a disk that refuses is.
        """
        names = self.names(kinds)
        oldest = 0 if most is None else max(len(names) - most, 0)
        wanted = [name for k, name in enumerate(names) if k >= oldest or not self._has_ended(name)]
        found = []
        for name in wanted:
            try:
                found.append(self.one(name))
            except (OSError, ValueError) as error:
                log.error("job_record_unreadable", file=f"{name}.json", error=str(error))
        for job in found:
            waits = job.state is JobState.QUEUED and job.kind in waiting and job.within is None
            if not job.state.final and not waits:
                self._end(job)
                cut_off(job)
        return sorted(found, key=lambda job: job.created.isoformat() if job.created else "")

    def _has_ended(self, identifier: str) -> bool:
        """As its head says; False also where that cannot be told."""
        assert self._folder is not None
        try:
            with (self._folder / f"{identifier}.json").open("rb") as file:
                state = _STATE.search(file.read(_HEAD))
            return state is not None and JobState(state[1].decode()).final
        except (OSError, ValueError):
            return False

    def _end(self, job: AnyJob) -> None:
        job.end(JobState.FAILED, _cut_off(job))
        try:
            self.save(job)
        except StorageError as error:  # the next start says the same of it
            log.error("job_not_saved", job=job.identifier, error=str(error))


def second_of(identifier: str) -> str:
    """When a job was asked for, as its id says."""
    return identifier.partition("-")[2].partition("-")[0]


def _cut_off(job: AnyJob) -> errors.PlatformError:
    again = "ask again"
    if job.kind == "acquisition" and job.within is None:
        again = f"have the shots made that are missing (POST /acquisitions/{job.identifier}/resume), or ask anew"
    return errors.PlatformError(
        f"the daemon stopped while this {job.kind} was {job.state}",
        why="a restart never switches outputs on by itself",
        remedy=f"{again}; shots that were stored are among the recordings, under this id",
    )


def record_of(job: AnyJob) -> StoredJob:
    """What is kept of a job, as it is now."""
    times = JobTimes(created=iso(job.created), started=iso(job.started), finished=iso(job.finished))
    error = None if job.error is None else _error_record(job.error)
    names = (*_AS_THEY_ARE, "within", "place", "arrival")
    paused = {"paused": True} if job.state is JobState.QUEUED and job.pause_requested.is_set() else {}
    return StoredJob.model_validate({n: getattr(job, n) for n in names} | paused | {"times": times, "error": error})


def _job(record: AnyJobRecord) -> AnyJob:
    job: AnyJob = Job(
        record.kind,
        record.request,
        record.result,
        record.total,
        record.unit,
        identifier=record.identifier,
        state=record.state,
        phase=str(record.state),
        done=record.done,
        warnings=list(record.warnings),
        within=record.within,
        place=record.place,
        arrival=record.arrival,
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
    """ISO 8601; None: not yet."""
    return None if when is None else when.isoformat()

"""Jobs on disk, so that an id that was given out still answers after a restart.

A job that was waiting or running when the daemon died comes back as failed: outputs are never switched on again by a
restart, and a client that asks learns what happened and where its shots are.
"""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

import structlog

from drivers import errors
from platform_daemon.store import write_file

from .jobs import Job, JobState

log = structlog.get_logger()


class JobRecords:
    """One JSON file per job in `folder`; None: nothing is kept (the one-shot command line)."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def save(self, job: Job) -> None:
        """Write the job as it is now.  Raises StorageError."""
        if self._folder is not None:
            write_file(self._folder / f"{job.identifier}.json", json.dumps(_record(job), indent=1).encode())

    def load(self) -> list[Job]:
        """All jobs of earlier runs, oldest first; those cut off are failed and saved so.  Bad files are logged."""
        found = []
        for path in sorted(self._folder.glob("*.json")) if self._folder else []:
            try:
                found.append(_job(json.loads(path.read_text())))
            except (OSError, ValueError, KeyError, TypeError) as error:
                log.error("job_record_unreadable", file=path.name, error=str(error))
        for job in found:
            if not job.state.final:
                job.end(JobState.FAILED, _cut_off(job))
                self.save(job)
        return sorted(found, key=lambda job: job.created.isoformat() if job.created else "")


def _cut_off(job: Job) -> errors.PlatformError:
    return errors.PlatformError(
        f"the daemon stopped while this {job.kind} was {job.state}",
        why="a restart never switches outputs on by itself",
        remedy="ask again; shots that were stored are among the recordings, under this id",
    )


def _record(job: Job) -> dict[str, Any]:
    return {
        "kind": job.kind,
        "identifier": job.identifier,
        "request": job.request,
        "total": job.total,
        "unit": job.unit,
        "state": str(job.state),
        "done": job.done,
        "result": job.result,
        "warnings": job.warnings,
        "times": {k: _iso(getattr(job, k)) for k in ("created", "started", "finished")},
        "error": None if job.error is None else _error_record(job.error),
    }


def _job(record: dict[str, Any]) -> Job:
    keys = ("kind", "identifier", "request", "total", "unit", "done", "result", "warnings")
    job = Job(**{k: record[k] for k in keys}, state=JobState(record["state"]), phase=record["state"])
    for name, text in record["times"].items():
        setattr(job, name, None if text is None else datetime.fromisoformat(text))
    if record["error"] is not None:
        job.error = _error(record["error"])
    if job.state.final:
        job.ended.set()
    return job


def _error_record(error: Exception) -> dict[str, str]:
    if not isinstance(error, errors.PlatformError):
        error = errors.PlatformError(f"unexpected {type(error).__name__}", why=str(error))
    parts = {k: getattr(error, k) for k in ("what", "where", "why", "remedy")}
    return {"title": error.title, **parts}


def _error(record: dict[str, str]) -> errors.PlatformError:
    error = errors.PlatformError(record.pop("what"), **{k: record[k] for k in ("where", "why", "remedy")})
    error.title = record["title"]
    return error


def _iso(when: datetime | None) -> str | None:
    return None if when is None else when.isoformat()

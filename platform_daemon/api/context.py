"""What every route needs: the engine and the folders; handed in once by `app.py`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from fastapi import Depends, Request

from platform_daemon.analysis import Library
from platform_daemon.engine import Engine, Job

from .problems import problem


@dataclass(frozen=True)
class Context:
    """Engine, folders of recordings, fit results and diagnoses, adopted models, folder of calibrations, and what has
    warmed up."""

    engine: Engine
    recordings: Path
    fits: Path
    diagnoses: Path
    models: Library
    calibrations: Path
    warm: dict[str, bool]


async def _context(request: Request) -> Context:
    context: Context = request.app.state.context
    return context


Shared = Annotated[Context, Depends(_context)]


def job_body(job: Job, links: dict[str, str]) -> dict[str, Any]:
    """A job as JSON."""
    progress = job.progress()
    return {
        "id": job.identifier,
        "kind": job.kind,
        "state": str(job.state),
        "progress": {
            "done": progress.done,
            "total": progress.total,
            "unit": progress.unit,
            "phase": progress.phase,
            "fraction": progress.fraction,
            "time_left_s": progress.time_left_s,
        },
        "created": _iso(job.created),
        "started": _iso(job.started),
        "finished": _iso(job.finished),
        "request": job.request,
        "result": dict(job.result),
        "warnings": list(job.warnings),
        "error": None if job.error is None else problem(job.error, links.get("self")),
        "links": links,
    }


def _iso(when: Any) -> str | None:
    return None if when is None else when.isoformat()

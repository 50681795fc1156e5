"""What every route needs: the owner of the hardware, the analyses and the folders; handed in once by `app.py`."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

from fastapi import Body, Depends, Request
from fastapi import Path as InPath

from platform_daemon.core.hardware.catalogue import Catalogue
from platform_daemon.core.jobs.submit_options import ShuttingDown
from platform_daemon.core.jobs.workers.bounds import TaskCancelled
from platform_daemon.core.jobs.workers.task_executor import Task, TaskExecutor, ignore_progress
from platform_daemon.core.recordings.data_folder import DataFolder
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.access import Confirmation
from platform_daemon.core.service.analysis_jobs import AnalysisJobs
from platform_daemon.core.service.platform_service import JobService, PlatformService

from .event_tail import EventTail
from .metrics import Metrics

ResultT = TypeVar("ResultT")
PartT = TypeVar("PartT")
EXAMPLE_RECORDING = "acquisition-20261121T101500-1a2b3c"


@dataclass(frozen=True, kw_only=True)
class Context:
    """What routes work with.

    Attributes:
        hardware: the platform service; feature_service: the service of a feature in the hardware process.
        catalogue: resonators and sequences by name.
        analyses: jobs on stored recordings; executor: computes what requests wait for, and the analyses.
        folders: of the daemon's data.
        events: for those who listen; metrics: for Prometheus.
        parts: what features keep in this process, by its type: `context.part(AlarmBoard)`.
    """

    hardware: PlatformService
    feature_service: Callable[[str], Any]
    catalogue: Catalogue
    analyses: AnalysisJobs
    executor: TaskExecutor
    folders: DataFolder
    events: EventTail
    metrics: Metrics
    parts: Mapping[type, Any]

    def part(self, kind: type[PartT]) -> PartT:
        """The part of that type.  Raises KeyError if the daemon has none."""
        found: PartT = self.parts[kind]
        return found

    def close(self) -> None:
        """The worker processes end, and listeners are let go.  Idempotent."""
        self.events.close()
        for each in self.parts.values():
            if hasattr(each, "close"):
                each.close()
        self.analyses.close()
        self.executor.close()

    def run(self, task: Task[ResultT]) -> ResultT:
        """Compute what a request waits for.  Raises OverBounds, WorkerLost, ShuttingDown, and what the task raises."""
        try:
            return self.executor.run("preview", task, ignore_progress, threading.Event())
        except TaskCancelled:
            raise ShuttingDown("the daemon is shutting down", remedy="start it again, then ask again") from None

    def jobs_of(self, kind: str) -> JobService:
        """Who has the jobs of a kind."""
        return self.hardware if feature_of(kind).kind.needs_hardware else self.analyses


async def _context(request: Request) -> Context:
    context: Context = request.app.state.context
    return context


Shared = Annotated[Context, Depends(_context)]
JobId = Annotated[str, InPath(description="id of the job, as its POST answered it")]
RecordingId = Annotated[
    str, InPath(description="id of the recording: its file name without the last suffix", examples=[EXAMPLE_RECORDING])
]
Frame = Annotated[int, InPath(description="number of the frame, from 0", examples=[0])]
ModelLabel = Annotated[str, InPath(description="NAME or NAME@VERSION of an adopted model", examples=["quiet@1"])]


Confirmed = Annotated[Confirmation, Body(description="no values: `{}`, or nothing")]
CONFIRMED = Confirmation()

"""What every route needs: the owner of the hardware, the analyses and the folders; handed in once by `app.py`."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeVar

from fastapi import Body, Depends, Request
from fastapi import Path as InPath

from platform_daemon.alarms import AlarmBoard, Watch
from platform_daemon.analysis import Library
from platform_daemon.engine import ANALYSES, AnalysisJobs, Catalogue, ShuttingDown
from platform_daemon.link import Hardware, JobHolder, LocalJobs
from platform_daemon.schemas import Confirmation
from platform_daemon.workers import Computer, Stopped, Task

from .event_tail import EventTail
from .metrics import Metrics
from .trend_keeper import TrendKeeper

ResultT = TypeVar("ResultT")
EXAMPLE_RECORDING = "acquisition-20261121T101500-1a2b3c"


@dataclass(frozen=True)
class Context:
    """What routes work with.

    hardware: its owner; catalogue: what can be measured; analyses: those asked for; previews: who computes what a
    request waits for; then folders; models: adopted ones; events: for those who listen; watch: what raises
    alarms; trends: of specimens.
    """

    hardware: Hardware
    catalogue: Catalogue
    analyses: AnalysisJobs
    previews: Computer
    recordings: Path
    fits: Path
    diagnoses: Path
    characterisations: Path
    procedures: Path
    models: Library
    calibrations: Path
    events: EventTail
    alarms: AlarmBoard
    metrics: Metrics
    watch: Watch
    trends: TrendKeeper

    def close(self) -> None:
        """The processes that compute end, and listeners are let go.  Idempotent."""
        self.events.close()
        self.watch.close()
        self.trends.close()
        self.analyses.close()
        self.previews.close()

    def computed(self, task: Task[ResultT]) -> ResultT:
        """What a request waits for.  Raises OverBounds, Busy, ShuttingDown, and what the task raises."""
        try:
            return self.previews.compute("preview", task, lambda done, what: None, threading.Event())
        except Stopped:
            raise ShuttingDown("the daemon is shutting down", remedy="start it again, then ask anew") from None

    def holder(self, kind: str) -> JobHolder:
        """Who holds the jobs of a kind."""
        return LocalJobs(self.analyses) if kind in ANALYSES else self.hardware


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

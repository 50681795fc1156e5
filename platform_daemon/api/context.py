"""What every route needs: the owner of the hardware, the analyses and the folders; handed in once by `app.py`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeVar

import anyio
from fastapi import Body, Depends, Request
from fastapi import Path as InPath

from platform_daemon.analysis import Library
from platform_daemon.engine import ANALYSES, AnalysisJobs, Catalogue
from platform_daemon.link import Hardware, JobHolder, LocalJobs
from platform_daemon.schemas import Confirmation

ResultT = TypeVar("ResultT")
EXAMPLE_RECORDING = "acquisition-20261121T101500-1a2b3c"


@dataclass(frozen=True)
class Context:
    """The owner of the hardware, what can be measured, analyses asked for, folders of recordings, fit results,
    diagnoses, characterisations and logs of procedures, adopted models, folder of calibrations, what has warmed up."""

    hardware: Hardware
    catalogue: Catalogue
    analyses: AnalysisJobs
    recordings: Path
    fits: Path
    diagnoses: Path
    characterisations: Path
    procedures: Path
    models: Library
    calibrations: Path
    warm: dict[str, bool]

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


async def at_once(work: Callable[[], ResultT]) -> ResultT:
    """In a thread of its own: downloads and other long requests must not make it wait, nor it them."""
    return await anyio.to_thread.run_sync(work, limiter=anyio.CapacityLimiter(1))

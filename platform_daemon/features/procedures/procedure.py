"""What a procedure is: steps one after another, each decided from the reports of those before it.

A procedure touches neither the engine nor a file; `conductor.py` makes its steps.  What is made of its recording
afterwards is a `Conclusion`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

from platform_daemon.core.jobs.jobs import AnyJob, Job
from platform_daemon.core.jobs.run_task import run_task_with_retry
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.schemas.acquisitions import AcquisitionResult, AcquisitionSummary
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import Origins
from platform_daemon.features.acquire.destination import Destination
from platform_daemon.features.acquire.work import AcquisitionJob

from .schema import (
    AnyOutcome,
    AnyProcedureRequest,
    ProcedureResult,
    ProcedureSummary,
    RingingLine,
    StepReport,
    SweptValue,
)

ProcedureJob = Job[AnyProcedureRequest, ProcedureResult]
StepSequence = Generator["Step", StepReport, str]
"""Yields steps, is sent the report of each, returns why it ended."""


@dataclass(frozen=True)
class Step:
    """One step: an acquisition, and in what it differs from the others."""

    values: tuple[SweptValue, ...]
    acquisition: AcquisitionRequest
    listen_near_hz: float | None = None
    """Where to look for what rings in its last shot, fitted or not; None: not at all."""
    origins: Origins = field(default_factory=dict)
    """Where values of its sequence come from that the request of the procedure does not give."""
    name: str = ""
    """What it is for, as it stands in the recording: tune, ramp, series, sweep."""

    def label(self, number: int) -> StepLabel:
        """As it stands in the recording."""
        said = {v.key: v.value if isinstance(v.value, str) else _number_or_text(v.value) for v in self.values}
        return StepLabel(number, said, self.name)

    def named(self, number: int) -> str:
        """In words, for errors and progress."""
        return f"step {number} ({', '.join(map(str, self.values))})" if self.values else f"step {number}"


def _number_or_text(value: float | tuple[float, ...]) -> float | str:
    return ",".join(f"{x:g}" for x in value) if isinstance(value, tuple) else float(value)


class Procedure(Protocol):
    """What is measured, step by step."""

    @property
    def request(self) -> AnyProcedureRequest:
        """What was requested."""

    @property
    def title(self) -> str:
        """What it does, for the recording, as "sweep over field_ut"."""

    @property
    def ends_early(self) -> str | None:
        """What ends it before its outline does, in words; None: nothing."""

    @property
    def open_ended(self) -> bool:
        """It may be complete before its outline is made."""

    @property
    def outcome(self) -> AnyOutcome | None:
        """What it has found so far in addition to the results of its steps; None: it finds nothing more."""

    def outline(self) -> Sequence[Step]:
        """The steps that it makes at most, as far as they are known beforehand: checked before anything moves."""

    def steps(self) -> StepSequence:
        """The steps one after another.  May raise PlatformError for a report that it cannot continue from."""

    def conclude(self, job: str, result: ProcedureResult) -> None:
        """It has ended as it should, and its recording is there: keep what is to be kept.  Raises StorageError."""


class Conclusion(Protocol):
    """What a procedure makes of its recording once that is there: no hardware is needed for it."""

    def share(self, outline: ProcedureSummary) -> float:
        """Of all the procedure's time, 0 to 1: so much is likely to be left when the last shot is made."""

    def __call__(self, job: ProcedureJob, recording: Path, tell: Callable[[str, float], None]) -> None:
        """Put it into the job's result, and on disk.  tell: phase, and the share of the conclusion that is done; may
        raise Cancelled, and rests where the procedure is paused."""


class ShotFiles(Protocol):
    """The shots of a procedure on disk, while it runs; frames are counted from 0."""

    def file(self, frame: int) -> Path:
        """The recording of one shot."""

    def usable(self, frame: int) -> bool:
        """An excited shot that no device flagged."""

    def blank(self, frame: int) -> bool:
        """A shot without excitation that no device flagged."""


@runtime_checkable
class ReadsShots(Protocol):
    """A procedure that reads shots itself, in addition to the reports of its steps."""

    def reads(self, files: ShotFiles) -> None:
        """Called before the first step."""


class Steps(Protocol):
    """Who makes steps: today the engine of this process (engine_steps.py), later one in another process."""

    def check(self, request: AcquisitionRequest, origins: Origins) -> AcquisitionSummary:
        """What a step would be; nothing moves.  Raises InputError."""

    def begin(
        self, request: AcquisitionRequest, destination: Destination, label: StepLabel, within: AnyJob, origins: Origins
    ) -> AcquisitionJob:
        """Queue a step; what stops the procedure `within` stops it.  Raises InputError, ShuttingDown."""


class Fits(Protocol):
    """Who fits the shots of a step: today the engine while it measures, later a process of its own."""

    def of(self, made: AcquisitionResult) -> FitReport | None:
        """The fits of what a step has measured, in the order of its shots; None: none were requested."""

    def ringing(self, shot: Path, near_hz: float) -> RingingLine | None:
        """What rings in the shot of this file near a frequency, fitted or not; None: nothing."""


@dataclass(frozen=True)
class Ringing:
    """What rings in a shot.  A task of the task executor."""

    shot: Path
    near_hz: float

    def __call__(self, tell: Callable[[float, str], None]) -> RingingLine | None:
        """Raises RecordingError."""
        from .ringing import ringing_line

        return ringing_line(self.shot, self.near_hz)


class OnlineFits:
    """The fits that ran during the series and came with the job.  executor: looks for what rings."""

    def __init__(self, executor: TaskExecutor) -> None:
        self._executor = executor

    def of(self, made: AcquisitionResult) -> FitReport | None:
        """See Fits."""
        return made.fit

    def ringing(self, shot: Path, near_hz: float) -> RingingLine | None:
        """See Fits."""
        return run_task_with_retry(self._executor, "procedure", Ringing(shot, near_hz))

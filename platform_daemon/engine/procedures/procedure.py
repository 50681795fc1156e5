"""What a procedure is: steps one after another, each decided from the reports of those before it.

A procedure touches neither the engine nor a file; `conductor.py` makes its steps.  What is made of its recording
afterwards is a `Conclusion`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from platform_daemon import analysis
from platform_daemon.schemas import (
    AcquisitionRequest,
    AcquisitionResult,
    AcquisitionSummary,
    AnyOutcome,
    AnyProcedureRequest,
    FitReport,
    ProcedureResult,
    ProcedureSummary,
    RingingLine,
    StepReport,
    SweptValue,
)
from platform_daemon.store import StepLabel
from platform_daemon.workers import Computer

from ..computed import computed_surely
from ..jobs import AnyJob, Job
from ..work.destination import Destination
from ..work.series import AcquisitionJob

ProcedureJob = Job[AnyProcedureRequest, ProcedureResult]
StepSequence = Generator["Step", StepReport, str]
"""Yields steps, is sent the report of each, returns why it ended."""


@dataclass(frozen=True)
class Step:
    """One step: an acquisition, and in what it differs from the others."""

    values: tuple[SweptValue, ...]
    acquisition: AcquisitionRequest
    listen_near_hz: float | None = None
    """Where to look for what rings in its last shot, fitted or not; None: nobody asks."""

    def label(self, number: int) -> StepLabel:
        """As it stands in the recording."""
        said = {v.key: v.value if isinstance(v.value, str) else _number_or_text(v.value) for v in self.values}
        return StepLabel(number, said)

    def named(self, number: int) -> str:
        """In words, for errors and progress."""
        return f"step {number} ({', '.join(map(str, self.values))})" if self.values else f"step {number}"


def _number_or_text(value: float | tuple[float, ...]) -> float | str:
    return ",".join(f"{x:g}" for x in value) if isinstance(value, tuple) else float(value)


class Procedure(Protocol):
    """What is measured, step by step."""

    @property
    def request(self) -> AnyProcedureRequest:
        """What was asked for."""

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
        """What it has found so far beside the results of its steps; None: it finds nothing more."""

    def outline(self) -> Sequence[Step]:
        """The steps that it makes at most, as far as they are known beforehand: checked before anything moves."""

    def steps(self) -> StepSequence:
        """The steps one after another.  May raise PlatformError for a report that it cannot go on from."""

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
    """A procedure that looks at shots itself, beside the reports of its steps."""

    def reads(self, files: ShotFiles) -> None:
        """Called before the first step."""


class Steps(Protocol):
    """Who makes steps: today the engine of this process (engine_steps.py), later one in another process."""

    def check(self, request: AcquisitionRequest) -> AcquisitionSummary:
        """What a step would be; nothing moves.  Raises InputError."""

    def begin(
        self, request: AcquisitionRequest, destination: Destination, label: StepLabel, within: AnyJob
    ) -> AcquisitionJob:
        """Queue a step; what stops the procedure `within` stops it.  Raises InputError, ShuttingDown."""


class Fits(Protocol):
    """Who fits the shots of a step: today the engine while it measures, later a process of its own."""

    def of(self, made: AcquisitionResult) -> FitReport | None:
        """The fits of what a step has measured, in the order of its shots; None: none were asked for."""

    def ringing(self, shot: Path, near_hz: float) -> RingingLine | None:
        """What rings in the shot of this file near a frequency, fitted or not; None: nothing."""


@dataclass(frozen=True)
class Ringing:
    """What rings in a shot.  A task for whoever computes."""

    shot: Path
    near_hz: float

    def __call__(self, tell: Callable[[float, str], None]) -> RingingLine | None:
        """Raises RecordingError."""
        return analysis.ringing_line(self.shot, self.near_hz)


class OnlineFits:
    """The fits that ran beside the shots and came with the job.  computer: looks for what rings."""

    def __init__(self, computer: Computer) -> None:
        self._computer = computer

    def of(self, made: AcquisitionResult) -> FitReport | None:
        """See Fits."""
        return made.fit

    def ringing(self, shot: Path, near_hz: float) -> RingingLine | None:
        """See Fits."""
        return computed_surely(self._computer, "procedure", Ringing(shot, near_hz))

"""Procedures: what is asked for, what it would be, what every step has brought, and the log on disk."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from .base import Absent, Schema, Vector, Verdict, example
from .characterisation import CharacteriseOutcome, CharacteriseRequest
from .ramps import RampOutcome, RampRequest
from .sweeps import SweepRequest
from .tunes import TuneOutcome, TuneRequest

AnyProcedureRequest = Annotated[
    SweepRequest | TuneRequest | RampRequest | CharacteriseRequest, Field(discriminator="kind")
]
"""A procedure that can be asked for."""
AnyOutcome = Annotated[TuneOutcome | RampOutcome | CharacteriseOutcome, Field(discriminator="kind")]
"""What a procedure finds beside the results of its steps; a sweep finds nothing more."""


class SweptValue(Schema):
    """A key of a step and its value."""

    key: str
    """The key, as it was asked for."""
    value: int | float | str | Vector
    """Its value, in the unit that the key names."""

    def __str__(self) -> str:
        return f"{self.key} = {self.value:g}" if isinstance(self.value, int | float) else f"{self.key} = {self.value}"


class StepEstimate(Schema):
    """A result of a step over its good fits, in the unit that its name holds."""

    median: float
    """Median."""
    scatter: float | None
    """Standard deviation from shot to shot; null for a single shot."""
    std: float | None
    """Median of the standard deviations that the fits give; null: held, or of a result that has none."""


class RingingLine(Schema):
    """An oscillation in a shot, fitted or not."""

    frequency_hz: float
    """Frequency, Hz."""
    significance: float
    """Power over the level of the noise beside it, summed over the channels."""
    snr: float
    """Amplitude at its beginning over the noise of one sample, in the channel where it is strongest."""


class StepReport(Schema):
    """One step as it was made."""

    step: int
    """Number of the step, from 1."""
    values: tuple[SweptValue, ...]
    """What was different in this step."""
    complete: bool
    """All shots that were asked for are there; false: it was cut short."""
    verdict: Verdict
    """good: at least one usable shot, fitted if fits were asked for; refused: none."""
    reason: str | None
    """Why it was refused; null for a good one."""
    frames: tuple[int, ...]
    """Numbers of its frames in the recording, from 0; refused and repeated shots are among them."""
    refused: int
    """Excited shots that were refused and repeated."""
    fitted: int
    """Good fits."""
    heard: Absent[RingingLine] = None
    """The line that rings in its last shot; missing: nobody listened, or nothing rings."""
    results: dict[str, StepEstimate]
    """Parameters by public name, and r2, nrmse, chi2_per_dof; empty without a good fit."""
    acquisitions: tuple[str, ...]
    """Ids of the jobs that made it, more than one if shots were repeated or it was paused."""
    warnings: tuple[str, ...]
    """What may spoil it."""
    started: str
    """When it began, ISO 8601."""
    seconds: float
    """How long it took, s."""


class ProcedureResult(Schema):
    """What a procedure has brought so far."""

    planned_steps: int | None
    """Steps that it makes at most; null: not known beforehand."""
    recording: Absent[str] = None
    """Id of the one recording with the shots of all steps; it is there once the procedure has ended."""
    file: Absent[str] = None
    """Name of its file."""
    steps: tuple[StepReport, ...]
    """Step by step, in order."""
    outcome: Absent[AnyOutcome] = None
    """What it has found so far; missing: it finds nothing beside the results of its steps."""
    stopped: str | None
    """Why it ended; null: it has not."""


class ProcedureLog(Schema):
    """The log of a procedure on disk, written anew after every step, and what `sweep --json` writes."""

    model_config = ConfigDict(json_schema_extra=example("procedure_log"))

    software_version: str
    """Version of the software that measured."""
    job: str
    """Id of its job."""
    started: str
    """When it began, ISO 8601."""
    request: AnyProcedureRequest
    """What was asked for, with every default."""
    result: ProcedureResult
    """What came out; `stopped` is null as long as it goes on, and after a crash for ever."""


class PlannedStep(Schema):
    """One step as it would be."""

    step: int
    """Number of the step, from 1."""
    values: tuple[SweptValue, ...]
    """What is different in this step."""
    shots: int
    """Shots, blank ones included."""
    duration_s: float
    """Length, pauses included, s."""
    disk_bytes: int
    """Size of the samples on disk, bytes."""


class ProcedureSummary(Schema):
    """A procedure as it would be: every step is checked, nothing moves."""

    model_config = ConfigDict(json_schema_extra=example("procedure_summary"))

    resonator: str
    """Name of the resonator."""
    shots: int
    """Shots in all, blank ones included."""
    duration_s: float
    """Length of all steps, pauses included, s; computing comes on top."""
    disk_bytes: int
    """Size of the samples on disk, bytes."""
    steps: tuple[PlannedStep, ...]
    """Step by step."""
    stop_when: str | None
    """What ends it early, in words; null: nothing."""
    warnings: tuple[str, ...]
    """What may spoil it, each said once."""

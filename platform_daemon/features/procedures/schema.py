"""Procedures: request, plan, results of the steps, and the log on disk."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Union

from pydantic import ConfigDict, Field

from platform_daemon.core.registry import procedures
from platform_daemon.core.schemas.base import Absent, Schema, Vector, Verdict, example
from platform_daemon.core.schemas.value_sources import ValueSource

from .request_schema import Outcome, ProcedureRequest

if TYPE_CHECKING:
    AnyProcedureRequest = ProcedureRequest
    AnyOutcome = Outcome
else:
    _REQUESTS = tuple(feature.load(each.request) for feature, each in procedures())
    _OUTCOMES = tuple(feature.load(each.outcome) for feature, each in procedures() if each.outcome)
    AnyProcedureRequest = Annotated[Union[_REQUESTS], Field(discriminator="kind")]  # noqa: UP007 made at run time
    """A request of a procedure of any kind that the registry has."""
    AnyOutcome = Annotated[Union[_OUTCOMES], Field(discriminator="kind")]  # noqa: UP007 made at run time
    """What a procedure finds in addition to the results of its steps; a sweep finds nothing more."""


class SweptValue(Schema):
    """A key of a step and its value."""

    key: str
    """The key, as it was requested."""
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
    """Power relative to the noise at neighbouring frequencies, summed over the channels."""
    snr: float
    """Amplitude at its beginning over the noise of one sample, in the channel where it is strongest."""


class StepReport(Schema):
    """One step as it was made."""

    step: int
    """Number of the step, from 1."""
    values: tuple[SweptValue, ...]
    """What was different in this step."""
    complete: bool
    """All shots that were requested are there; false: it was cut short."""
    verdict: Verdict
    """good: at least one usable shot, fitted if fits were requested; refused: none."""
    reason: str | None
    """Why it was refused; null for a good one."""
    frames: tuple[int, ...]
    """Numbers of its frames in the recording, from 0; refused and repeated shots are among them."""
    refused: int
    """Excited shots that were refused and repeated."""
    fitted: int
    """Good fits."""
    heard: Absent[RingingLine] = None
    """The line that rings in its last shot; missing: no line was searched, or none was found."""
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
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the step come from, and the limits that held for it."""


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
    """What it has found so far; missing: it finds nothing more than the results of its steps."""
    stopped: str | None
    """Why it ended; null: it has not."""


class ProcedureLog(Schema):
    """The log of a procedure on disk, rewritten after every step, and what `sweep --json` writes."""

    model_config = ConfigDict(json_schema_extra=example("procedure_log"))

    software_version: str
    """Version of the software that measured."""
    job: str
    """Id of its job."""
    started: str
    """When it began, ISO 8601."""
    request: AnyProcedureRequest
    """What was requested, with every default."""
    result: ProcedureResult
    """What came out; `stopped` is null while it continues, and stays null after a crash."""


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
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the last step come from, and the limits that hold for it."""

"""Procedures: what is asked for, what it would be, what every step has brought, and the log on disk."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from .base import Absent, Finite, Given, Request, Schema, Vector, Verdict, example
from .characterisation import SIGNIFICANCE, CharacterisationReport, Level
from .requests import AcquisitionRequest

MOST_STEPS = 1000
Comparison = TypeAliasType("Comparison", Literal[">", "<", ">=", "<="])
LONGEST_PAUSE_S = 28_800.0
PauseLimit = Annotated[float, Field(gt=0, le=604_800, allow_inf_nan=False)]
_Key = Annotated[str, Field(min_length=1, max_length=100)]
_Number = Annotated[int, Field(ge=-(10**12), le=10**12)] | Finite
_Value = _Number | Annotated[str, Field(max_length=100)] | Annotated[tuple[Finite, ...], Field(strict=False)]


class SweepAxis(Request):
    """One key of the acquisition and the values that it takes: a range (`start`, `stop`, `step`), or `values`."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"key": "field_ut", "start": 50, "stop": 300, "step": 50}]}
    )

    key: _Key
    """A key of the acquisition, nested by dots, as sequence.field_t; keys of `sequence` also by their own name, and
    fields, times and frequencies also in people's units: field_ut, rx_ms, f_tx_khz."""
    start: Given[_Number] = None
    """First value, in the unit that the key names."""
    stop: Given[_Number] = None
    """Last value, which is taken too if whole steps lead there."""
    step: Given[_Number] = None
    """From each value to the next one; negative: downwards."""
    values: Given[Annotated[tuple[_Value, ...], Field(strict=False, min_length=1, max_length=MOST_STEPS)]] = None
    """The values one by one, in the place of a range."""

    @model_validator(mode="after")
    def _range_or_values(self) -> SweepAxis:
        span = (self.start, self.stop, self.step)
        if (self.values is None) == all(part is None for part in span):
            raise ValueError("give either start, stop and step, or values")
        if self.values is None:
            if any(part is None for part in span):
                raise ValueError("a range needs start, stop and step")
            _count_of(*span)  # type: ignore[arg-type]
        return self

    @property
    def points(self) -> tuple[Any, ...]:
        """Every value, in order; of a range without rounding errors."""
        if self.values is not None:
            return self.values
        assert self.start is not None
        assert self.stop is not None
        assert self.step is not None
        first, step = Decimal(str(self.start)), Decimal(str(self.step))
        whole = all(isinstance(part, int) for part in (self.start, self.step))
        count = _count_of(self.start, self.stop, self.step)
        return tuple((int if whole else float)(first + k * step) for k in range(count))


def _count_of(start: float, stop: float, step: float) -> int:
    if step == 0:
        raise ValueError("a step of 0 leads nowhere: give the distance between two values")
    if (stop - start) * math.copysign(1.0, step) < 0:
        raise ValueError(f"steps of {step:g} do not lead from {start:g} to {stop:g}: change the sign of step")
    # From the values as they are written: as binary numbers 0.1, 0.2, 0.3 are not evenly spaced.
    steps = (Decimal(str(stop)) - Decimal(str(start))) / Decimal(str(step))
    if steps >= MOST_STEPS:
        raise ValueError(f"more than {MOST_STEPS} steps: make the step larger")
    return int(steps) + 1


class StopRule(Request):
    """Ends a procedure after the first step whose result is so."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"result": "phi_max_deg", "comparison": ">", "value": 40}]}
    )

    result: _Key
    """A result of the step, as phi_max_rad or chi2_per_dof; angles in degrees too, as phi_max_deg."""
    comparison: Comparison
    """How the step's median compares with `value`."""
    value: _Number
    """In the unit that the result names."""

    def __str__(self) -> str:
        return f"{self.result} {self.comparison} {self.value:g}"


class SweepRequest(Request):
    """A sweep: the same acquisition again and again, each step with other values of some keys, in one recording."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "kind": "sweep",
                    "acquisition": {"resonator": "jewel", "shots": 2, "sequence": {"rx_s": 2.0}},
                    "over": [{"key": "field_ut", "start": 50, "stop": 300, "step": 50}],
                    "stop_when": {"result": "phi_max_deg", "comparison": ">", "value": 40},
                },
                {
                    "kind": "sweep",
                    "acquisition": {"resonator": "thread"},
                    "over": [{"key": "axis", "values": ["x", "y"]}, {"key": "sequence.tx_periods", "values": [8, 10]}],
                },
            ]
        }
    )

    kind: Literal["sweep"]
    """A sweep."""
    acquisition: AcquisitionRequest
    """What every step has in common; `shots` and `blank_shots` are per step."""
    over: Annotated[tuple[SweepAxis, ...], Field(strict=False, min_length=1, max_length=5)]
    """Keys with their values; of several all combinations are made, the last one changes fastest."""
    stop_when: StopRule | None = None
    """Ends the sweep early; null: all steps are made."""
    longest_pause_s: PauseLimit = LONGEST_PAUSE_S
    """A pause that lasts longer ends the sweep, s: it holds up those that wait, and a change of calibration."""

    @model_validator(mode="after")
    def _bounded(self) -> SweepRequest:
        if (steps := math.prod(len(axis.points) for axis in self.over)) > MOST_STEPS:
            raise ValueError(f"{steps} steps are more than {MOST_STEPS}: ask for fewer values")
        return self


class CharacteriseRequest(Request):
    """A characterisation: many shots of one resonator in one recording, and the paper's tables from them."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"kind": "characterise", "acquisition": {"resonator": "jewel", "shots": 100, "blank_shots": 4}}
            ]
        }
    )

    kind: Literal["characterise"]
    """A characterisation."""
    acquisition: AcquisitionRequest
    """The shots; keys of `sequence` that are not given are those of the resonator's preset."""
    held_in_n50: dict[str, Finite] = Field(default={})
    """Losses that are held in the N50 fits, by public name, SI; empty: of a model with several losses lambda, at the
    median of its own D30 fits."""
    alpha: Level = SIGNIFICANCE
    """Level of significance of all comparisons together."""
    longest_pause_s: PauseLimit = LONGEST_PAUSE_S
    """A pause that lasts longer ends it, s: it holds up those that wait, and a change of calibration."""


ProcedureRequest = Annotated[SweepRequest | CharacteriseRequest, Field(discriminator="kind")]


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
    characterisation: Absent[CharacterisationReport] = None
    """What a characterisation has made of its shots; missing as long as it measures, and in other procedures."""
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
    request: ProcedureRequest
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

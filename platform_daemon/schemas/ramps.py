"""Ramp: what is asked for, and what it finds."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator

from .base import Absent, Schema
from .procedure_requests import ProcedureRequest
from .requests import FieldTesla

StepTesla = Annotated[float, Field(ge=1e-9, le=1e-3, allow_inf_nan=False)]
"""From one field to the next, T."""
_Chance = Annotated[float, Field(gt=0, lt=0.5, allow_inf_nan=False)]


class RampRequest(ProcedureRequest):
    """Ramp: raise the field step by step until side modes show, never where they are too likely to (paper,
    "Measurement Sequence")."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"kind": "ramp", "acquisition": {"resonator": "thread_imperfect"}, "max_t": 4e-4}]
        }
    )

    kind: Literal["ramp"]
    """Ramp."""
    start_t: FieldTesla | None = None
    """Field of the first step, T, at which there are no side modes yet; null: half that of the preset."""
    step_t: StepTesla = 1e-5
    """Highest step upwards, T, 1 nT to 1 mT; near the threshold steps get smaller."""
    max_t: FieldTesla | None = None
    """Field that it does not pass, T; null: the limit of the platform."""
    overdose_rate: _Chance = 0.25
    """Chance, of each step upwards, to lie above the threshold, as far as the shots before it tell."""
    false_stop_rate: _Chance = 0.002
    """Chance of calling side modes visible anywhere in a ramp where the z residual is below the visible level."""
    most_shots: Annotated[int, Field(ge=1, le=100)] = 6
    """Shots at one field at most, where it is in doubt."""

    @model_validator(mode="after")
    def _rises(self) -> RampRequest:
        if self.start_t is not None and self.max_t is not None and self.start_t > self.max_t:
            raise ValueError("start_t lies above max_t: start lower")
        return self


class RampThreshold(Schema):
    """Field at which the z residual passes the visible level, T."""

    value: float
    """Median."""
    low: float
    """Lower end of its 95 % interval."""
    high: float
    """Upper end."""


class RampStep(Schema):
    """One field of a ramp."""

    field_t: float
    """Field, T."""
    shots: int
    """Shots that were looked at."""
    phi_max_rad: float | None
    """Mean largest deflection by the fits, rad; null: no shot could be fitted."""
    z_residual_am2_per_s: float
    """Mean of the largest z residual of each shot, freed from noise, A m^2/s; 0: nothing stands out."""
    statistic: float
    """Base-10 logarithm of the e-value of the sequential test at this field."""
    verdict: Literal["below", "suspected", "visible"]
    """visible: side modes are there beyond the false-stop rate; suspected: the threshold may lie at or below."""


class RampLine(Schema):
    """A line in the z residual of the last field."""

    frequency_hz: float
    """Frequency, Hz."""
    size_am2_per_s: float
    """Largest size around it, A m^2/s."""
    near: Literal["f", "2f", "3f", "f_side"]
    """The multiple of the main mode that it lies at, within 3 %; else a side mode's own."""


class RampOutcome(Schema):
    """What a ramp has found so far."""

    kind: Literal["ramp"]
    """Ramp."""
    visible_am2_per_s: float
    """z residual from which side modes count as visible, A m^2/s."""
    threshold_t: RampThreshold | None
    """Threshold; null: not reached, or passed by the first field already."""
    operating_field_t: float | None
    """80 % of the threshold, or of the highest field where it was not reached; null: nothing rang, or the first
    field lies above."""
    max_field_t: float | None
    """Highest field that the specimen is to see from now on, T: the threshold, or the highest field tried; null:
    as above."""
    false_stop_rate: float
    """As asked for."""
    overdose_rate: float
    """As asked for."""
    steps: tuple[RampStep, ...]
    """Field by field, rising."""
    lines: tuple[RampLine, ...]
    """What the z residual is made of at the highest field."""
    lines_hz: tuple[float, ...]
    """Their frequencies, Hz."""
    overshoot_t: float
    """How far the highest field lies above the threshold found, T; 0: not."""
    drive_saturated: bool
    """The deflection has grown by less than half as much as the field, in the last steps."""
    specimen_file: Absent[str] = None
    """Where the limits are kept with the specimen."""

"""Ramp: its request and its result."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.base import Absent, Schema
from platform_daemon.core.schemas.requests import FieldTesla
from platform_daemon.features.procedures.request_schema import Outcome, ProcedureRequest

StepTesla = Annotated[float, Field(ge=1e-9, le=1e-3, allow_inf_nan=False)]
"""From one field to the next, T."""
RampBound = TypeAliasType("RampBound", Literal["requested_limit", "platform_limit", "earlier_ramp", "envelope"])
"""What a ramp does not pass: max_t of its request, the limit of the platform, what an earlier ramp has kept, or the
highest field that the rest of the safety envelope allows."""
RampEnd = TypeAliasType(
    "RampEnd",
    Literal["side_modes", "first_field", "next_step", "requested_limit", "platform_limit", "earlier_ramp", "envelope"],
)
RAMP_ENDS: dict[RampEnd, str] = {
    "side_modes": "side modes are visible",
    "first_field": "side modes are visible at the first field",
    "next_step": "the next step would be too likely to lie above the threshold",
    "requested_limit": "the highest field that was requested",
    "platform_limit": "the limit of the platform",
    "earlier_ramp": "the limit that an earlier ramp has kept",
    "envelope": "the highest field that coils and amplifier allow",
}
"""In words."""
RampReason = TypeAliasType("RampReason", Literal["step", "smaller_step", "bound", "doubt", "more_shots"])
"""Why a ramp goes to a field."""
_Chance = Annotated[float, Field(gt=0, lt=0.5, allow_inf_nan=False)]


def check_rises(start_t: float | None, max_t: float | None) -> None:
    """Raises ValueError for a ramp that begins above its highest field, T; None: not given."""
    if start_t is not None and max_t is not None and start_t > max_t:
        raise ValueError("start_t lies above max_t: start lower")


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
    """Highest step upwards, T; near the threshold steps get smaller."""
    max_t: FieldTesla | None = None
    """Field that it does not pass, T; null: the limit of the platform."""
    overdose_rate: _Chance = 0.25
    """Chance, of each step upwards, to lie above the threshold, as far as the shots before it tell."""
    false_stop_rate: _Chance = 0.002
    """Chance of calling side modes visible anywhere in a ramp where the z residual is below the visible level."""
    most_shots: Annotated[int, Field(ge=1, le=100)] = 6
    """Shots at one field at most, where it is in doubt."""

    predicted_by: Annotated[str | None, Field(min_length=1, max_length=100)] = None
    """Adopted model with a manufacturing error, NAME or NAME@VERSION, whose threshold is told beside the measured
    one; null: none is predicted."""

    @model_validator(mode="after")
    def _rises(self) -> RampRequest:
        check_rises(self.start_t, self.max_t)
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
    """Mean of the largest z residual of each shot, freed from noise, A m^2/s; 0: nothing exceeds the noise."""
    statistic: float
    """Base-10 logarithm of the e-value of the sequential test at this field."""
    verdict: Literal["below", "suspected", "visible"]
    """visible: side modes are there beyond the false-stop rate; suspected: the threshold may lie at or below."""


class RampChance(Schema):
    """A point of the posterior of the threshold."""

    field_t: float
    """Field, T."""
    chance: float
    """Chance that the threshold lies at or below it, as far as the shots so far tell."""


class RampNextField(Schema):
    """Where a ramp goes next."""

    field_t: float
    """Field, T."""
    chance: float
    """Chance that the threshold lies at or below it."""
    why: RampReason
    """step: a whole step up is allowed; smaller_step: of one only so much; bound: the highest field that it may go to
    is nearer than a step; doubt: here once more, for the threshold may lie at or below it; more_shots: here once more,
    for no step up is allowed yet, and more shots may allow one."""


class RampLine(Schema):
    """A line in the z residual of the last field."""

    frequency_hz: float
    """Frequency, Hz."""
    size_am2_per_s: float
    """Largest size around it, A m^2/s."""
    near: Literal["f", "2f", "3f", "f_side"]
    """The multiple of the main mode that it lies at, within 3 %; else a side mode's own."""


class RampPrediction(Schema):
    """The threshold by an adopted manufacturing error."""

    model: str
    """Label of the model."""
    threshold_t: float | None
    """Lowest field at which the z residual of its rotor passes the visible level, T, or the lowest that was computed;
    null: none up to `highest_field_t`, or it could not be predicted."""
    highest_field_t: Absent[float] = None
    """Highest field that was computed, T; missing: none was."""
    why: Absent[str] = None
    """Why it could not be predicted."""


class RampOutcome(Outcome):
    """What a ramp has found so far."""

    kind: Literal["ramp"]
    """Ramp."""
    visible_am2_per_s: float
    """z residual from which side modes count as visible, A m^2/s."""
    threshold_t: RampThreshold | None
    """Threshold; null: none was found up to `highest_field_t`, or the first field lies above it."""
    operating_field_t: float | None
    """80 % of the threshold, T; null: there is no threshold."""
    max_field_t: float | None
    """Highest field that the specimen is to see from now on, T: the threshold; null: there is no threshold, and
    nothing is kept."""
    highest_field_t: Absent[float] = None
    """Highest field that was tried, T; missing in outcomes of earlier versions."""
    ended_by: Absent[RampEnd] = None
    """Why it ended.  side_modes: they are visible; first_field: they are visible at the first field; next_step: the
    next step would be too likely to lie above the threshold; requested_limit, platform_limit, earlier_ramp, envelope:
    the bound that was reached: max_t, the limit of the platform, what an earlier ramp has kept, or the highest field
    that the rest of the safety envelope allows.  Missing as long as it goes on."""
    false_stop_rate: float
    """As requested."""
    overdose_rate: float
    """As requested."""
    steps: tuple[RampStep, ...]
    """Field by field, rising."""
    threshold_chances: Absent[tuple[RampChance, ...]] = None
    """Posterior of the threshold, fields rising, from the first field to 1.3 times the highest one; missing in outcomes
    of earlier versions."""
    next_field: Absent[RampNextField] = None
    """Where it goes next; missing: it has ended, or will."""
    predicted: Absent[RampPrediction] = None
    """The threshold by the model of `predicted_by`; missing before the end, and without such a model."""
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

"""Events, as their journal keeps them and `GET /events` sends them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from typing_extensions import TypeAliasType

from .base import Absent, FitVerdict, Schema, Verdict, example
from .jobs import JobState, Progress

EventKind = TypeAliasType(
    "EventKind", Literal["job", "shot", "fit", "measurand", "device", "interlock", "alarm", "schedule", "dropped"]
)


class JobEvent(Schema):
    """A job was queued, has begun, or has ended."""

    kind: Literal["job"] = "job"
    """Kind of event."""
    job: str
    """Id of the job."""
    job_kind: str
    """Kind of the job."""
    state: JobState
    """Where it is in its life."""
    progress: Progress
    """How far it is."""
    within: str | None
    """Id of the procedure that it is a step of; null: it belongs to none."""
    recording: str | None
    """Id of its recording; null: there is none, or none yet."""
    error: str | None
    """Why it failed; null: it did not."""


class ShotEvent(Schema):
    """A shot is on disk: from now on it counts, and can be read."""

    kind: Literal["shot"] = "shot"
    """Kind of event."""
    job: str
    """Id of its acquisition."""
    shot: int
    """Number in its acquisition, from 1."""
    of: int
    """Shots that were requested."""
    recording: str
    """Id of its recording."""
    frame: int
    """Its frame there, from 0."""
    blank: bool
    """A shot without excitation."""
    verdict: Verdict
    """Refused: it must not be used."""
    reason: str | None
    """Why it was refused; null for a good one."""


class FitEvent(Schema):
    """The on-line fit of a shot."""

    kind: Literal["fit"] = "fit"
    """Kind of event."""
    job: str
    """Id of its acquisition."""
    shot: int
    """Number in its acquisition, from 1."""
    verdict: FitVerdict
    """Refused: there is no result."""
    reason: str | None
    """Why there is none; null for a good one."""
    f_nat_hz: float | None
    """Natural frequency, Hz; null: there is no result."""
    f_nat_std_hz: float | None
    """Its standard deviation, Hz; null: there is none."""
    phi_max_rad: float | None
    """Largest deflection, rad; null: there is no result."""
    nrmse: float | None
    """Root mean square of the residual over that of the signal, 1; null: there is no result."""
    chi2_per_dof: float | None
    """chi^2 per degree of freedom against the measured noise, 1; null: there is no result."""
    whiteness: float | None
    """Of the residual, the least of all channels: 1 for noise alone, near 0 where something is left over."""
    warnings: tuple[str, ...]
    """What may make the numbers wrong."""
    seconds: float
    """Computing time, s."""
    specimen: Absent[str] = None
    """Name of the resonator; missing: an earlier version wrote it."""
    temperature_c: Absent[float] = None
    """Temperature of the platform, degrees Celsius; missing: not measured, or an earlier version wrote it."""


class MeasurandEvent(Schema):
    """A shot of a resonator that is calibrated as a sensor, as a reading of its quantity."""

    kind: Literal["measurand"] = "measurand"
    """Kind of event."""
    job: str
    """Id of its acquisition."""
    shot: int
    """Number in its acquisition, from 1."""
    specimen: str
    """Name of the resonator."""
    name: str
    """The quantity in words."""
    unit: str
    """Its unit."""
    calibration: str
    """KEY@VERSION of the calibration."""
    value: float | None
    """In the unit; null: there is no reading."""
    U: float | None
    """Expanded uncertainty, 95 %, in the unit; null: there is no reading."""
    reason: str | None
    """Why there is no reading; null: there is one."""
    within: bool | None
    """True: value ± U lies between the limits that the resonator's file declares; false: it lies beyond one of them, or
    there is no reading; null: it contains one of them, or there are none."""


class DeviceEvent(Schema):
    """A device has stopped to answer, or answers again."""

    kind: Literal["device"] = "device"
    """Kind of event."""
    device: str
    """Its role on the platform."""
    error: str | None
    """What is wrong; null: it answers again."""


class InterlockEvent(Schema):
    """The interlock has closed, or is open again."""

    kind: Literal["interlock"] = "interlock"
    """Kind of event."""
    why: str | None
    """Why power must stay off; null: power may go out."""


class AlarmEvent(Schema):
    """An alarm was raised, acknowledged or cleared."""

    kind: Literal["alarm"] = "alarm"
    """Kind of event."""
    alarm: str
    """What it is about, as "disk" or "drift:thread"; at most one alarm of a name is active."""
    state: Literal["raised", "acknowledged", "cleared"]
    """What became of it."""
    what: str
    """What is wrong, and what to do."""
    by: str | None = None
    """Who has acknowledged it; null: no one."""


class ScheduleEvent(Schema):
    """A row of the ledger of a schedule has changed."""

    kind: Literal["schedule"] = "schedule"
    """Kind of event."""
    schedule: str
    """Id of the schedule."""
    due: str
    """The instant, ISO 8601, UTC."""
    state: str
    """State of the row."""
    reason: str | None
    """Why it is not plainly `run`."""
    job: str | None
    """Id of the job; null: none was made."""
    active: bool = True
    """Did its schedule start by itself when it came to this?"""


class DroppedEvent(Schema):
    """A listener was too slow, or away for too long: events that it will not get."""

    kind: Literal["dropped"] = "dropped"
    """Kind of event."""
    count: int | None
    """Number of missed events; null: unknown, because a new journal was begun meanwhile."""


AnyEvent = Annotated[
    JobEvent
    | ShotEvent
    | FitEvent
    | MeasurandEvent
    | DeviceEvent
    | InterlockEvent
    | AlarmEvent
    | ScheduleEvent
    | DroppedEvent,
    Field(discriminator="kind"),
]
"""What an event says."""


class Event(Schema):
    """One event."""

    model_config = ConfigDict(json_schema_extra=example("event"))

    id: int
    """Number; later ones are larger."""
    at: str | None
    """When, ISO 8601, UTC; null: of `dropped`."""
    what: AnyEvent
    """What has happened."""

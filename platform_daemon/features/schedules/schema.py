"""What is measured by the calendar, and what became of each start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import ConfigDict, Field, create_model, model_validator
from typing_extensions import TypeAliasType

from platform_daemon.core.registry import Feature, job_features
from platform_daemon.core.schemas.acquisitions import ShotReading
from platform_daemon.core.schemas.base import Absent, ListPage, Priority, Request, Schema, Window, example
from platform_daemon.core.schemas.recordings import Terms
from platform_daemon.core.schemas.requests import ModelName
from platform_daemon.core.schemas.text import OneLine

SchedulePolicy = TypeAliasType("SchedulePolicy", Literal["coalesce", "skip", "run_all"])
"""What becomes of starts that could not begin in time: only the newest, none while one runs, or one after the other."""
LedgerState = TypeAliasType("LedgerState", Literal["due", "started", "run", "late", "skipped", "missed", "failed"])
"""due: waits until it may begin; started: claimed, its job runs or waits; the others are final."""


class TriggerRequest(Request):
    """When: exactly one of `every_s`, `cron` and `at`."""

    every_s: Annotated[float, Field(ge=1, allow_inf_nan=False)] | None = None
    """Interval, s, counted from `start` of the schedule, when it is due first: without `start` that is at once.
    Daylight saving does not move it."""
    cron: Annotated[str, Field(max_length=1000)] | None = None
    """Five fields as in Debian's cron: minute, hour, day, month, weekday; also `L`, `LW`, `5L` and `MON#2`."""
    at: Annotated[list[str], Field(min_length=1, max_length=1000)] | None = None
    """Local times, ISO 8601, or with an offset of their own."""
    time_zone: str = "UTC"
    """IANA name of the zone that `cron` and `at` are in."""
    jitter_s: Annotated[float, Field(ge=0, le=86_400, allow_inf_nan=False)] = 0.0
    """Each start is put off by up to this, s; the same instant always by the same."""


class WorkRequest(Request):
    """What a schedule starts: a job of a kind that the registry has."""

    kind: str
    """Kind of the job."""
    request: Any
    """As the POST of that kind takes it."""


class FitWorkRequest(Request):
    """A fit of the recording of a specimen that is the newest when it is due.  The platform is not needed for it."""

    kind: Literal["fit"]
    """Kind of the job."""
    specimen: Annotated[str, Field(min_length=1, max_length=200)]
    """Name of the sample, or of the resonator if none was given."""
    variant: ModelName | None = None
    """Model: thread, jewel or another declared one, or an adopted one; null: what the recording says."""
    terms: Terms = Field(default=[])
    """Further torque terms, as quadratic_drag."""
    window: Window = "d30"
    """Evaluation window: n50, d30, or seconds."""


class DiagnosisWorkRequest(Request):
    """A diagnosis of the recordings of a specimen that are the newest when it is due.  The platform is not needed."""

    kind: Literal["diagnosis"]
    """Kind of the job."""
    specimen: Annotated[str, Field(min_length=1, max_length=200)]
    """Name of the sample, or of the resonator if none was given."""
    newest: Annotated[int, Field(ge=1, le=200)] = 1
    """So many recordings are diagnosed together."""
    variant: ModelName | None = None
    """The declared model; null: what the recordings say."""
    base: ModelName | None = None
    """A declared or adopted model to start from in its place."""


def _of_kind(feature: Feature) -> Any:
    """The work of a kind of job: what the feature names, else `{"kind": ..., "request": ...}`."""
    if feature.kind.scheduled:
        return feature.load(feature.kind.scheduled)
    name = feature.kind.name
    pascal = "".join(part.capitalize() for part in name.split("_"))
    request = feature.request_type
    try:
        default: Any = request()
    except (TypeError, ValueError):  # something must be said
        default = ...
    about = f"As `POST /{feature.kind.plural}` takes it."
    fields: dict[str, Any] = {
        "kind": (Literal[name], Field(description="Kind of the job.")),
        "request": (request, Field(default, description=about)),
    }
    text = f"{feature.kind.article}, started by the calendar."
    return create_model(f"{pascal}WorkRequest", __base__=Request, __doc__=text, **fields)


if TYPE_CHECKING:
    AnyWorkRequest = WorkRequest
else:
    _WORKS = tuple(_of_kind(each) for each in job_features() if each.kind.needs_hardware or each.kind.scheduled)
    AnyWorkRequest = Annotated[Union[_WORKS], Field(discriminator="kind")]  # noqa: UP007 made at run time
    """A work of any kind that can be scheduled."""


class ScheduleRequest(Request):
    """A work that is started by the calendar."""

    model_config = ConfigDict(json_schema_extra=example("schedule_request"))

    name: Annotated[str, Field(min_length=1, max_length=100), OneLine]
    """Name of the schedule, one line."""
    trigger: TriggerRequest
    """When it is due."""
    work: AnyWorkRequest
    """What is started."""
    resonators: (
        Annotated[list[Annotated[str, Field(min_length=1, max_length=500)]], Field(min_length=1, max_length=1000)]
        | None
    ) = None
    """In turn: each start is with the next of them in the place of the resonator of the work, a series or procedure;
    null: always with that one.  Where a person has to mount it, a start waits until it is said to be there."""
    grace_s: Annotated[float, Field(gt=0, le=31_536_000, allow_inf_nan=False)] = 3600.0
    """A start that could not begin so long after its instant is missed, s."""
    policy: SchedulePolicy = "coalesce"
    """What becomes of starts that had to wait."""
    priority: Priority = 0
    """Of several that wait the highest begins first; its jobs have it in the queue."""
    start: str | None = None
    """Not before, ISO 8601 in the zone of the trigger; null: now."""
    until: str | None = None
    """Not after, ISO 8601 in the zone of the trigger; null: for ever."""
    max_failures: Annotated[int, Field(ge=1, le=1000)] = 3
    """So many failures in a row switch it off until an operator resumes it."""

    @model_validator(mode="after")
    def _one_priority(self) -> ScheduleRequest:
        if getattr(getattr(self.work, "request", None), "priority", 0):
            raise ValueError("its jobs have the priority of the schedule: give `priority` next to `work`")
        return self


class Schedule(Schema):
    """A schedule as it is."""

    model_config = ConfigDict(json_schema_extra=example("schedule"))

    id: str
    """Id."""
    request: ScheduleRequest | None
    """What was requested; null: another version has left it, and this one cannot read it."""
    created: str
    """Since when, ISO 8601, UTC."""
    active: bool
    """Does it start anything?"""
    reason: str | None
    """Why not: paused, stopped, removed, failed too often, cannot be read, its time zone is no more; null: it is
    active."""
    failures: int
    """In a row, until now."""
    next_due: str | None
    """Next instant, ISO 8601, UTC; null: there is none."""
    ahead_until: str | None
    """The clock has been here once, ISO 8601, UTC, and is before it again: nothing is due until then; null: no."""
    cron_in_words: str | None = None
    """`cron` of its trigger in words, as "At 22:00 every day", in the zone of the trigger; null: it has none."""


class ScheduleListing(ListPage[Schedule]):
    """All schedules, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("schedule", listed=True))


class SchedulePreview(Schema):
    """When a schedule would start."""

    model_config = ConfigDict(json_schema_extra=example("schedule_preview"))

    due: tuple[str, ...]
    """Its first instants, ISO 8601 in the zone of its trigger."""
    cron_in_words: str | None = None
    """`cron` of its trigger in words, in the zone of the trigger; null: it has none."""


class LedgerRow(Schema):
    """What became of one due instant.  Times are ISO 8601, UTC; null: not yet, or never."""

    model_config = ConfigDict(json_schema_extra=example("ledger_row"))

    number: int
    """Of the row, for paging."""
    due: str
    """The instant."""
    deadline: str
    """Until when it may begin."""
    state: LedgerState
    """Where it is."""
    reason: str | None
    """Why it is not plainly `run`."""
    started: str | None
    """When it was claimed, before its job was made."""
    ended: str | None
    """When the job was seen to have ended."""
    late_s: float | None
    """How long after its instant, jitter included, it was claimed, s."""
    job: str | None
    """Id of its job."""
    recording: str | None
    """Id of what it recorded."""
    measurand: Absent[ShotReading] = None
    """What that reads, by the mean of its shots; missing: its resonator is not calibrated as a sensor, or the recording
    has no good fit or is not in the index yet."""


class LedgerPage(ListPage[LedgerRow]):
    """Some rows, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("ledger_page"))

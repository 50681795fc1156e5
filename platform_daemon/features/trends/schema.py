"""Trends of a specimen: points, a control chart per quantity, and changes by name."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.base import (
    Absent,
    ClockKind,
    FiniteOrNull,
    Given,
    ListPage,
    Request,
    Root,
    Schema,
    example,
)
from platform_daemon.core.schemas.requests import SequencePreset
from platform_daemon.core.schemas.text import OneLine, SeveralLines
from platform_daemon.features.models.schema import AdoptedModelSummary

ChangeName = TypeAliasType(
    "ChangeName",
    Literal["wear", "lost_magnetisation", "side_mode", "noise_source", "turned", "gain_or_calibration", "drift"],
)
"""What a change is taken for; drift: none of the others."""


class TrendPoint(Schema):
    """Shots of one recording that were made within ten minutes."""

    at: str
    """When the first one was made, ISO 8601."""
    clock: Absent[ClockKind] = None
    """Clock that this goes by; missing: the file does not say."""
    recording: str
    """Id of the recording."""
    shots: int
    """How many shots."""
    temperature_c: FiniteOrNull
    """Their mean temperature, degrees Celsius; null: not measured."""


class TrendChart(Schema):
    """The control chart of one quantity; a value per point in each list, null where there is none."""

    quantity: str
    """Its name, with its unit."""
    value: tuple[FiniteOrNull, ...]
    """Mean over the shots of the point."""
    corrected: tuple[FiniteOrNull, ...]
    """The same at the reference temperature; as measured where no temperature is known."""
    U: Absent[tuple[FiniteOrNull, ...]] = None
    """Expanded uncertainty of each value, 95 %, in its unit; null: not known; missing: it was not asked for, or is no
    parameter of a fit."""
    reference_c: FiniteOrNull
    """Reference temperature, degrees Celsius; null: none was measured."""
    relative_per_k: FiniteOrNull
    """Temperature coefficient there, relative to the value, 1/K; of an orientation in rad/K; null: not known."""
    relative_per_k_std: FiniteOrNull
    """Its standard deviation, 1/K."""
    score: tuple[FiniteOrNull, ...]
    """Each point against what those before it say, standard deviations; null while the chart learns."""
    ewma: tuple[FiniteOrNull, ...]
    """Exponentially weighted mean of the scores."""
    limit: tuple[FiniteOrNull, ...]
    """The chart is out of control where |ewma| is larger."""
    smoothed: Absent[tuple[FiniteOrNull, ...]] = None
    """Of f_nat_hz: ewma as a value at the temperature of the point, Hz, by what the chart has learned until now;
    missing: of other quantities."""
    low: Absent[tuple[FiniteOrNull, ...]] = None
    """Lower control limit of `smoothed`, likewise, Hz."""
    high: Absent[tuple[FiniteOrNull, ...]] = None
    """Upper control limit of it, Hz."""


class TrendChange(Schema):
    """Something has changed by more than chance."""

    name: ChangeName
    """What it is taken for."""
    what: str
    """The same in words, with what to do."""
    quantities: tuple[str, ...]
    """What has changed, the chart that noticed it first."""
    relative: FiniteOrNull
    """Change of the first quantity between what was expected and the newest points, relative to its value; of an
    orientation in rad."""
    since: str
    """Of the first point after the change, as far as that can be said, ISO 8601."""
    since_recording: str
    """Id of its recording."""
    noticed: str
    """Of the point at which a chart left its limits, ISO 8601."""
    noticed_after_shots: int
    """Shots from `since` to `noticed`."""
    stands: bool
    """At the newest point it is still so."""


class TrendMeasurand(Schema):
    """What a specimen that is calibrated as a sensor reads, a value per point in each list."""

    name: str
    """The quantity in words."""
    unit: str
    """Its unit."""
    calibration: str
    """KEY@VERSION of the calibration."""
    value: tuple[FiniteOrNull, ...]
    """By the mean of the shots of the point, in the unit; null: nothing can be read."""
    U: tuple[FiniteOrNull, ...]
    """Expanded uncertainty, 95 %, in the unit; null: nothing can be read."""
    smoothed: tuple[FiniteOrNull, ...]
    """What the weighted mean of the control chart of f_nat_hz reads, in the unit; null: the chart learns, or nothing
    can be read."""
    low: tuple[FiniteOrNull, ...]
    """Lower control limit of `smoothed`, in the unit."""
    high: tuple[FiniteOrNull, ...]
    """Upper control limit of it, in the unit."""


class TrendReport(Schema):
    """Months of a specimen."""

    model_config = ConfigDict(json_schema_extra=example("trend_report"))

    specimen: str
    """Name of the sample."""
    points: tuple[TrendPoint, ...]
    """Oldest first."""
    charts: tuple[TrendChart, ...]
    """A chart per quantity."""
    measurand: Absent[TrendMeasurand] = None
    """What it reads; missing: it is not calibrated as a sensor."""
    changes: tuple[TrendChange, ...]
    """What is more than chance, oldest first."""
    points_to_false_alarm: float
    """A specimen that does not change raises an alarm in one of its charts once in so many points, on average."""
    notes: tuple[str, ...]
    """What was assumed, and what is missing."""


class SpecimenListing(ListPage[str]):
    """Specimens with recordings that were fitted."""

    model_config = ConfigDict(json_schema_extra=example("specimen_listing"))


class SpecimenResonator(Schema):
    """A resonator as which a specimen was measured, as the catalogue has it now."""

    name: str
    """Name in words, as its recordings say it."""
    key: str | None
    """Name to use in an acquisition; null: the catalogue has none of that name any more."""
    recordings: int
    """So many recordings say so."""
    variant: str | None
    """Its bearing: thread or jewel."""
    max_field_t: FiniteOrNull
    """Highest field it is to see, T; null: no ramp has found one."""
    operating_field_t: FiniteOrNull
    """Field at which it is to be used, T."""
    sequence: SequencePreset | None
    """Its preset, a tuned one where there is one."""


class SpecimenPage(Schema):
    """What is known of a specimen, in one place."""

    model_config = ConfigDict(json_schema_extra=example("specimen_page"))

    specimen: str
    """Name of the sample, or of the resonator if none was given."""
    recordings: int
    """With on-line fits."""
    shots: int
    """That were fitted."""
    first: str
    """Begin of the first recording, ISO 8601."""
    last: str
    """Begin of the newest one, ISO 8601."""
    resonators: tuple[SpecimenResonator, ...]
    """As which it was measured, newest first."""
    calibrations: dict[str, int]
    """Recordings by the calibration of the receive side that they were made with."""
    models: tuple[AdoptedModelSummary, ...]
    """Adopted models that were made from its recordings."""
    tags: tuple[str, ...]
    """Tags of its recordings."""
    changes: tuple[TrendChange, ...]
    """Active changes that are more than chance."""
    links: dict[str, str]
    """Path by what is there."""


class BaselineRequest(Request):
    """A specimen is accepted as it is: a bearing was replaced, a magnet exchanged."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"by": "DC", "reason": "new jewel"}]})

    since: Given[Annotated[str, Field(max_length=40)]] = None
    """From when on, ISO 8601; missing: from now on, which is after the newest recording."""
    by: Annotated[str, Field(min_length=1, max_length=200, pattern=r"\S"), OneLine]
    """Name of the person."""
    reason: Annotated[str, Field(min_length=1, max_length=2000, pattern=r"\S"), SeveralLines]
    """Why."""


class Baseline(Schema):
    """Since when a specimen is what it is now."""

    model_config = ConfigDict(json_schema_extra=example("baseline"))

    since: str
    """Its charts begin there, ISO 8601, UTC."""
    by: str
    """Who has accepted it."""
    reason: str
    """Why."""
    accepted: str
    """When, ISO 8601, UTC."""


class Baselines(Root[dict[str, Baseline]]):
    """The file of the baselines, by specimen."""

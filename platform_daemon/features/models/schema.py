"""Adopted models: what they are made of, the evidence for them, and the list of all that a fit can use."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from platform_daemon.core.schemas.base import (
    Absent,
    ListPage,
    Request,
    Schema,
    example,
)
from platform_daemon.core.schemas.fits import Covariance, FileDigest
from platform_daemon.core.schemas.problems import UnreadableFile
from platform_daemon.core.schemas.text import OneLine, SeveralLines
from platform_daemon.diagnosis.report_schema import DiagnosisReport


class AdoptedTermRecord(Schema):
    """A further torque term of an adopted model."""

    term: str
    """Name of the torque term."""
    values: dict[str, float]
    """Its coefficients by public name, SI."""
    std: dict[str, float | None]
    """Their standard deviations; null: not estimated."""
    free: bool
    """Fits estimate the strength again; else they hold it."""


class ReceiverEffectRecord(Schema):
    """An effect of the receive chain that an adopted model undoes in the samples before a fit."""

    id: str
    """Name of the effect."""
    strength: float
    """In the unit of the effect."""
    axis: str | None
    """The one channel it acts on, x, y or z; null: all."""
    source: str | None
    """Of crosstalk: the channel it comes from."""
    target: str | None
    """Of crosstalk: the channel it goes to."""
    even: bool | None
    """It acts on the even (true) or odd (false) harmonics of fundamental_hz only; null: on everything."""
    fundamental_hz: float | None
    """Fundamental of those harmonics, Hz."""


class AdoptedRotorRecord(Schema):
    """A manufacturing error of an adopted model, with which fits take a rotor of five degrees of freedom."""

    id: str
    """Name of the effect."""
    parameter: str
    """The rotor's parameter that it is."""
    strength: float
    """In rad, a displacement in m; fits hold it."""
    std: float | None
    """Its standard deviation; null: not known."""
    held: dict[str, float]
    """What fits hold beside it, SI: distance of the magnets, damping, creep; friction: where they start."""
    ratio: dict[str, float]
    """Parameters of the rotor over those of one angle, by public name: where fits start."""
    covariance: Absent[Covariance] = None
    """Of the strength and of what is held beside it, which the errors of fits contain; absent: not known."""


class AdoptionEvidence(Schema):
    """What is kept with an adopted model so that anybody can judge it, or repeat the diagnosis."""

    adopted_by: str
    """Who adopted it."""
    adopted_at: str
    """When, ISO 8601."""
    software_version: str
    """With which version of this software."""
    started_from: str
    """The model that was diagnosed."""
    forced: str | None
    """Why it was adopted although the data are not explained; null: they are."""
    recordings: tuple[FileDigest, ...]
    """The data that were diagnosed."""
    diagnosis: DiagnosisReport | dict[str, Any] = Field(union_mode="left_to_right")
    """The diagnosis; of another version of this software: as it stands in its file."""


class AdoptedModelRecord(Schema):
    """A named, versioned model with the evidence for it; the content of its file."""

    model_config = ConfigDict(json_schema_extra=example("adopted_model_record"))

    format: Literal["platform-daemon adopted model 1"]
    """Version of this form."""
    name: str
    """Name of the model."""
    version: int
    """Counts from 1; a version never changes."""
    label: str
    """NAME@VERSION: what results and recordings are marked with."""
    base: str
    """The declared model that it extends."""
    terms: tuple[AdoptedTermRecord, ...]
    """Further torque terms."""
    receiver: tuple[ReceiverEffectRecord, ...]
    """What is undone on the receive side."""
    rotor: Absent[AdoptedRotorRecord] = None
    """A manufacturing error, with which fits take a rotor of five degrees of freedom; absent: none."""
    digest: str
    """SHA-256 of base, terms, receiver and rotor: of everything that a fit depends on."""
    evidence: AdoptionEvidence | dict[str, Any] = Field(union_mode="left_to_right")
    """Why it was adopted; of another version of this software: as it stands in its file."""


class Retirement(Schema):
    """Who took a version out of use, when and why."""

    at: str
    """When, ISO 8601."""
    by: str
    """Who."""
    reason: str
    """Why."""


class AdoptedModelReport(AdoptedModelRecord):
    """An adopted model, and whether it is still in use."""

    model_config = ConfigDict(json_schema_extra=example("adopted_model_report"))

    retired: Retirement | None
    """null: in use."""


class AdoptedModelSummary(Schema):
    """One line of the list of adopted models."""

    model_config = ConfigDict(json_schema_extra=example("adopted_model_summary"))

    label: str
    """NAME@VERSION."""
    name: str
    """Name of the model."""
    version: int
    """Counts from 1."""
    base: str
    """The declared model that it extends."""
    terms: tuple[str, ...]
    """Names of its further torque terms, and of its manufacturing error."""
    receiver: tuple[str, ...]
    """Names of the effects that it undoes on the receive side."""
    adopted_at: str | None
    """When, ISO 8601; null: its file does not say."""
    adopted_by: str | None
    """By whom; null: its file does not say."""
    digest: str
    """SHA-256 of everything that a fit depends on."""
    retired: Retirement | None
    """null: in use."""


class AdoptedModelListing(ListPage[AdoptedModelSummary]):
    """Every version of every adopted model, by name and version."""

    model_config = ConfigDict(json_schema_extra=example("adopted_model_summary", listed=True))


class ModelListing(AdoptedModelListing):
    """What a fit can use; `items` are the versions of adopted models."""

    model_config = ConfigDict(json_schema_extra=example("model_listing"))

    declared: tuple[str, ...]
    """Declared models by name."""
    terms: tuple[str, ...]
    """Further torque terms by name."""
    broken: tuple[UnreadableFile, ...]
    """Adopted models of this page whose files are damaged, each with the reason."""


class RetirementRequest(Request):
    """A version of an adopted model is taken out of use."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"reason": "thread replaced", "by": "DC"}]})

    reason: Annotated[str, Field(min_length=1, max_length=2000), SeveralLines]
    """Why; is kept."""
    by: Annotated[str, Field(max_length=200), OneLine] = ""
    """Who; is kept."""

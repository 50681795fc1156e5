"""A job as the data folder keeps it, so that an id that was given out still answers after a restart."""

from __future__ import annotations

from typing import Annotated, Generic, Literal

from pydantic import Field

from .acquisitions import AcquisitionResult
from .analysis_requests import DiagnosisRequest, RecordingFitRequest
from .base import Absent, NoResult, Root, Schema
from .calibrations import CalibrationReport
from .characterisation import CharacterisationReport, CharacterisationRequest
from .diagnosis import DiagnosisReport
from .fits import FitReport
from .jobs import JobState, RequestT, ResultT
from .platform import SelfTestReport
from .problems import ErrorRecord
from .procedures import AnyProcedureRequest, ProcedureResult
from .requests import AcquisitionRequest, CalibrationRequest
from .self_tests import SelfTestRequest


class JobTimes(Schema):
    """When a job was asked for, began and ended, ISO 8601; null: not yet."""

    created: str | None
    """Asked for."""
    started: str | None
    """Begun."""
    finished: str | None
    """Ended."""


class JobRecord(Schema, Generic[RequestT, ResultT]):
    """One job: a file in the data folder."""

    kind: str
    """Kind of the job."""
    identifier: str
    """Id of the job."""
    request: RequestT
    """What was asked for, with every default."""
    total: int | float
    """How much is to be done, in `unit`."""
    unit: str
    """shots, frames or share."""
    state: JobState
    """Where it is in its life."""
    done: int | float
    """How much is done."""
    result: ResultT
    """What came out so far."""
    warnings: tuple[str, ...]
    """What may spoil the result."""
    times: JobTimes
    """When."""
    error: ErrorRecord | None
    """Why it failed; null: it did not."""
    within: Absent[str] = None
    """Id of the procedure that it is a step of; missing: it stands for itself."""
    place: Absent[int] = None
    """Place in the queue, from 0; missing: nobody has put it in order."""
    arrival: Absent[int] = None
    """Number in the order in which jobs came to the queue; missing: it never did."""
    paused: Absent[bool] = None
    """It waits, and does not begin before it is resumed; missing: it does."""


class AcquisitionRecord(JobRecord[AcquisitionRequest, AcquisitionResult]):
    """The record of a series."""

    kind: Literal["acquisition"]
    """A series of shots."""


class FitRecord(JobRecord[RecordingFitRequest, FitReport | NoResult]):
    """The record of a fit."""

    kind: Literal["fit"]
    """A fit."""


class DiagnosisRecord(JobRecord[DiagnosisRequest, DiagnosisReport | NoResult]):
    """The record of a diagnosis."""

    kind: Literal["diagnosis"]
    """A diagnosis."""


class CharacterisationRecord(JobRecord[CharacterisationRequest, CharacterisationReport | NoResult]):
    """The record of a characterisation."""

    kind: Literal["characterisation"]
    """A characterisation."""


class CalibrationRecord(JobRecord[CalibrationRequest, CalibrationReport | NoResult]):
    """The record of a calibration."""

    kind: Literal["calibration"]
    """A calibration."""


class SelfTestRecord(JobRecord[SelfTestRequest, SelfTestReport | NoResult]):
    """The record of a self-test."""

    kind: Literal["self_test"]
    """A self-test."""


class ProcedureRecord(JobRecord[AnyProcedureRequest, ProcedureResult]):
    """The record of a procedure."""

    kind: Literal["procedure"]
    """A procedure."""


AnyQueuedRequest = AcquisitionRequest | CalibrationRequest | SelfTestRequest | AnyProcedureRequest
"""What can wait for the platform."""
AnyJobRecord = (
    AcquisitionRecord
    | FitRecord
    | DiagnosisRecord
    | CharacterisationRecord
    | CalibrationRecord
    | SelfTestRecord
    | ProcedureRecord
)


class StoredJob(Root[Annotated[AnyJobRecord, Field(discriminator="kind")]]):
    """The record of a job of any kind."""

"""Long work as jobs: what was asked, how far it is, what came out."""

from __future__ import annotations

from enum import StrEnum
from typing import Generic, Literal, TypeVar

from pydantic import ConfigDict

from .acquisitions import AcquisitionResult
from .analysis_requests import DiagnosisRequest, RecordingFitRequest
from .base import NoResult, Root, Schema, example
from .calibrations import CalibrationReport
from .characterisation import CharacterisationReport, CharacterisationRequest
from .diagnosis import DiagnosisReport
from .fits import FitReport
from .platform import SelfTestReport
from .problems import Problem
from .procedures import AnyProcedureRequest, ProcedureResult
from .requests import AcquisitionRequest, CalibrationRequest
from .self_tests import SelfTestRequest

RequestT = TypeVar("RequestT")
ResultT = TypeVar("ResultT")


class JobState(StrEnum):
    """queued -> running -> done | failed | cancelled; a queued job may be cancelled at once."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def final(self) -> bool:
        """True if nothing more will happen."""
        return self in (JobState.DONE, JobState.FAILED, JobState.CANCELLED)


class Progress(Schema):
    """How far a job is."""

    done: float
    """So much is done, in `unit`."""
    total: float
    """Of so much."""
    unit: str
    """shots, frames or share."""
    phase: str
    """What it does now."""
    fraction: float
    """Share done, 0 to 1."""
    time_left_s: float | None
    """Time left, s; null: not known yet."""


class Job(Schema, Generic[RequestT, ResultT]):
    """One piece of work."""

    id: str
    """Id of the job."""
    kind: str
    """Kind of the job."""
    state: JobState
    """Where it is in its life."""
    progress: Progress
    """How far it is."""
    created: str | None
    """When it was asked for, ISO 8601."""
    started: str | None
    """When it began, ISO 8601; null: it waits, or was cancelled before."""
    finished: str | None
    """When it ended, ISO 8601; null: not yet."""
    request: RequestT
    """What was asked for, with every default."""
    result: ResultT
    """What came out so far."""
    warnings: tuple[str, ...]
    """What may spoil the result."""
    error: Problem | None
    """Why it failed; null: it did not."""
    links: dict[str, str]
    """Path by what is there."""


class QueuedJob(Job[RequestT, ResultT], Generic[RequestT, ResultT]):
    """One that waits for the platform, if others are there before it."""

    priority: int
    """Of several that wait the highest begins first."""


class AcquisitionJob(QueuedJob[AcquisitionRequest, AcquisitionResult]):
    """A series of shots; `result` grows with every shot on disk, its id is that of the recording."""

    model_config = ConfigDict(json_schema_extra=example("acquisition_job"))

    kind: Literal["acquisition"]
    """A series of shots."""


class FitJob(Job[RecordingFitRequest, FitReport | NoResult]):
    """A fit of a stored recording; `result` is what `fit --json` writes, and empty before that."""

    model_config = ConfigDict(json_schema_extra=example("fit_job"))

    kind: Literal["fit"]
    """A fit."""


class DiagnosisJob(Job[DiagnosisRequest, DiagnosisReport | NoResult]):
    """A diagnosis; `result` is what `diagnose --json` writes, and empty before that."""

    model_config = ConfigDict(json_schema_extra=example("diagnosis_job"))

    kind: Literal["diagnosis"]
    """A diagnosis."""


class CharacterisationJob(Job[CharacterisationRequest, CharacterisationReport | NoResult]):
    """A characterisation; `result` is what `characterise --json` writes, and empty before that."""

    model_config = ConfigDict(json_schema_extra=example("characterisation_job"))

    kind: Literal["characterisation"]
    """A characterisation."""


class CalibrationJob(QueuedJob[CalibrationRequest, CalibrationReport | NoResult]):
    """A calibration; `result` is what `calibrate --json` writes, and empty before that."""

    model_config = ConfigDict(json_schema_extra=example("calibration_job"))

    kind: Literal["calibration"]
    """A calibration."""
    question: str | None
    """What the operator has to do before it goes on; null: nothing."""


class SelfTestJob(QueuedJob[SelfTestRequest, SelfTestReport | NoResult]):
    """A self-test; `result` is what `self-test --json` writes, and empty before that, or if it has failed."""

    model_config = ConfigDict(json_schema_extra=example("self_test_job"))

    kind: Literal["self_test"]
    """A self-test."""


class ProcedureJob(QueuedJob[AnyProcedureRequest, ProcedureResult]):
    """A procedure: steps one after the other, each an acquisition, all shots in one recording; `result` grows with
    every step."""

    model_config = ConfigDict(json_schema_extra=example("procedure_job", "tune_job"))

    kind: Literal["procedure"]
    """A procedure."""
    paused: bool
    """It rests at a safe point with outputs off, or will do so after the shot under way, until it is resumed."""


class AcquisitionJobs(Root[tuple[AcquisitionJob, ...]]):
    """All acquisitions, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("acquisition_job", listed=True))


class FitJobs(Root[tuple[FitJob, ...]]):
    """All fits, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("fit_job", listed=True))


class DiagnosisJobs(Root[tuple[DiagnosisJob, ...]]):
    """All diagnoses, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("diagnosis_job", listed=True))


class CharacterisationJobs(Root[tuple[CharacterisationJob, ...]]):
    """All characterisations, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("characterisation_job", listed=True))


class CalibrationJobs(Root[tuple[CalibrationJob, ...]]):
    """All calibrations, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("calibration_job", listed=True))


class ProcedureJobs(Root[tuple[ProcedureJob, ...]]):
    """All procedures, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("procedure_job", listed=True))


class SelfTestJobs(Root[tuple[SelfTestJob, ...]]):
    """All self-tests, oldest first."""

    model_config = ConfigDict(json_schema_extra=example("self_test_job", listed=True))

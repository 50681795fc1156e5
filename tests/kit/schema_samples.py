"""What the daemon wrote before its results had types: real output, with the schema that it must still be."""

from __future__ import annotations

from platform_daemon.core.jobs.kinds import job_list_type, job_type, record_type
from platform_daemon.core.schemas.acquisitions import AcquisitionSummary, SeriesReport
from platform_daemon.core.schemas.base import Root, Schema
from platform_daemon.core.schemas.calibrations import CalibrationReport, CalibrationsInUse
from platform_daemon.core.schemas.derived import DerivedReport, EnvelopesReport
from platform_daemon.core.schemas.fits import FitBatch, FitReport
from platform_daemon.core.schemas.harmonics import HarmonicsBatch, HarmonicsReport, ShotHarmonics
from platform_daemon.core.schemas.platform import (
    DeviceListing,
    DeviceSurvey,
    EntryPoints,
    FaultReset,
    PlatformStatus,
    Readiness,
    ResonatorListing,
)
from platform_daemon.core.schemas.problems import Problem, ProblemKind
from platform_daemon.core.schemas.recordings import DmdtSeries, RecordingInfo, RecordingListing
from platform_daemon.core.schemas.stop import Health, StopReport
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.features.diagnose.live_schema import LiveDiagnosisLog
from platform_daemon.features.fit.prediction_schema import PredictionReport
from platform_daemon.features.fit.sliding_schema import SlidingReport
from platform_daemon.features.models.schema import (
    AdoptedModelListing,
    AdoptedModelRecord,
    AdoptedModelReport,
    AdoptedModelSummary,
    ModelListing,
)
from tests.kit.data import DATA

FOLDER = DATA / "schemas"

# On the command line: indented by one, floats as Python prints them.
CLI: dict[str, type[Schema | Root]] = {
    "fit_thread_derived": FitReport,
    "fit_jewel_n50": FitReport,
    "fit_example_jewel": FitReport,
    "fit_angle": FitReport,
    "fit_batch": FitBatch,
    "sliding": SlidingReport,
    "harmonics": HarmonicsReport,
    "harmonics_batch": HarmonicsBatch,
    "prediction": PredictionReport,
    "prediction_term": PredictionReport,
    "devices": DeviceSurvey,
    "devices_missing": DeviceSurvey,
    "measure": SeriesReport,
    "info": RecordingInfo,
    "diagnosis": DiagnosisReport,
    "live_diagnosis": LiveDiagnosisLog,
    "models": AdoptedModelListing,
    "model_show_retired": AdoptedModelReport,
    "calibration_receive": CalibrationReport,
    "calibration_transmit": CalibrationReport,
}
# Records of jobs in the data folder: the same form.
STORED: dict[str, type[Schema | Root]] = {
    name: record_type(name.partition("_")[0])
    for name in (
        "acquisition_done",
        "acquisition_cancelled",
        "calibration_done",
        "calibration_done_transmit",
        "diagnosis_failed",
        "fit_done",
    )
}
# By REST: as FastAPI writes a response model, which is pydantic's own JSON.
REST: dict[str, type[Schema | Root]] = {
    "root": EntryPoints,
    "health": Health,
    "ready": Readiness,
    "ready_503": Readiness,
    "platform": PlatformStatus,
    "platform_after": PlatformStatus,
    "devices": DeviceListing,
    "resonators": ResonatorListing,
    "reset": FaultReset,
    "stop": StopReport,
    "problem_kind": ProblemKind,
    "dry_run": AcquisitionSummary,
    "acquisition_queued": job_type("acquisition"),
    "acquisition_done": job_type("acquisition"),
    "acquisition_cancelled": job_type("acquisition"),
    "acquisitions": job_list_type("acquisition"),
    "live": ShotHarmonics,
    "harmonics": ShotHarmonics,
    "harmonics_blank": ShotHarmonics,
    "recordings": RecordingListing,
    "recording": RecordingInfo,
    "dmdt": DmdtSeries,
    "sliding": SlidingReport,
    "fit_queued": job_type("fit"),
    "fit_done": job_type("fit"),
    "fit_blank": job_type("fit"),
    "fit_angle": job_type("fit"),
    "fits": job_list_type("fit"),
    "derived": DerivedReport,
    "envelopes": EnvelopesReport,
    "predict": PredictionReport,
    "diagnosis_queued": job_type("diagnosis"),
    "diagnosis_done": job_type("diagnosis"),
    "diagnosis_failed": job_type("diagnosis"),
    "adopt": AdoptedModelRecord,
    "models": ModelListing,
    "models_retired": ModelListing,
    "retire": AdoptedModelSummary,
    "calibration_queued": job_type("calibration"),
    "calibration_receive": job_type("calibration"),
    "calibration_transmit": job_type("calibration"),
    "calibrations": job_list_type("calibration"),
    "activate": CalibrationsInUse,
    **dict.fromkeys(
        (
            *("live_none", "dry_run_error", "dry_run_invalid", "recording_404", "activate_422", "continue_409"),
            *("not_found", "not_allowed"),
        ),
        Problem,
    ),
}
# A frame that was never offered to the fit had its `samples` before `r2`; now every frame has the same order.
REORDERED = {"cli/measure", "rest/fit_blank"}


def text_of(folder: str, name: str) -> str:
    """The file as it was written."""
    return (FOLDER / folder / f"{name}.json").read_text(encoding="utf-8")

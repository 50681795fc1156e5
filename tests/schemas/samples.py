"""What the daemon wrote before its results had types: real output, with the schema that it must still be."""

from __future__ import annotations

from pathlib import Path

from platform_daemon import schemas as s

FOLDER = Path(__file__).parents[1] / "data" / "schemas"

# On the command line: indented by one, floats as Python prints them.
CLI: dict[str, type[s.Schema | s.Root]] = {
    "fit_thread_derived": s.FitReport,
    "fit_jewel_n50": s.FitReport,
    "fit_example_jewel": s.FitReport,
    "fit_angle": s.FitReport,
    "fit_batch": s.FitBatch,
    "sliding": s.SlidingReport,
    "harmonics": s.HarmonicsReport,
    "harmonics_batch": s.HarmonicsBatch,
    "prediction": s.PredictionReport,
    "prediction_term": s.PredictionReport,
    "devices": s.DeviceSurvey,
    "devices_missing": s.DeviceSurvey,
    "measure": s.SeriesReport,
    "info": s.RecordingInfo,
    "diagnosis": s.DiagnosisReport,
    "live_diagnosis": s.LiveDiagnosisLog,
    "models": s.AdoptedModelListing,
    "model_show_retired": s.AdoptedModelReport,
    "calibration_receive": s.CalibrationReport,
    "calibration_transmit": s.CalibrationReport,
}
# Records of jobs in the data folder: the same form.
STORED: dict[str, type[s.Schema | s.Root]] = dict.fromkeys(
    (
        *("acquisition_done", "acquisition_cancelled", "calibration_done", "calibration_done_transmit"),
        *("diagnosis_failed", "fit_done"),
    ),
    s.StoredJob,
)
# By REST: as FastAPI writes a response model, which is pydantic's own JSON.
REST: dict[str, type[s.Schema | s.Root]] = {
    "root": s.EntryPoints,
    "health": s.Health,
    "ready": s.Readiness,
    "ready_503": s.Readiness,
    "platform": s.PlatformStatus,
    "platform_after": s.PlatformStatus,
    "devices": s.DeviceListing,
    "resonators": s.ResonatorListing,
    "reset": s.FaultReset,
    "stop": s.StopReport,
    "problem_kind": s.ProblemKind,
    "dry_run": s.AcquisitionSummary,
    "acquisition_queued": s.AcquisitionJob,
    "acquisition_done": s.AcquisitionJob,
    "acquisition_cancelled": s.AcquisitionJob,
    "acquisitions": s.AcquisitionJobs,
    "live": s.ShotHarmonics,
    "harmonics": s.ShotHarmonics,
    "harmonics_blank": s.ShotHarmonics,
    "recordings": s.RecordingListing,
    "recording": s.RecordingInfo,
    "dmdt": s.DmdtSeries,
    "sliding": s.SlidingReport,
    "fit_queued": s.FitJob,
    "fit_done": s.FitJob,
    "fit_blank": s.FitJob,
    "fit_angle": s.FitJob,
    "fits": s.FitJobs,
    "derived": s.DerivedReport,
    "envelopes": s.EnvelopesReport,
    "predict": s.PredictionReport,
    "diagnosis_queued": s.DiagnosisJob,
    "diagnosis_done": s.DiagnosisJob,
    "diagnosis_failed": s.DiagnosisJob,
    "adopt": s.AdoptedModelRecord,
    "models": s.ModelListing,
    "models_retired": s.ModelListing,
    "retire": s.AdoptedModelSummary,
    "calibration_queued": s.CalibrationJob,
    "calibration_receive": s.CalibrationJob,
    "calibration_transmit": s.CalibrationJob,
    "calibrations": s.CalibrationJobs,
    "activate": s.CalibrationsInUse,
    **dict.fromkeys(
        (
            *("live_none", "dry_run_error", "dry_run_invalid", "recording_404", "activate_422", "continue_409"),
            *("not_found", "not_allowed"),
        ),
        s.Problem,
    ),
}
# A frame that was never offered to the fit had its `samples` before `r2`; now every frame has the same order.
REORDERED = {"cli/measure", "rest/fit_blank"}


def text_of(folder: str, name: str) -> str:
    """The file as it was written."""
    return (FOLDER / folder / f"{name}.json").read_text(encoding="utf-8")

"""What crosses a boundary: requests, results, jobs, problems, and the table of parameters; pydantic and nothing else.

base               one base class, one way to leave a key out, one way to write JSON
parameters         the one table of parameters: symbol, unit, how they are shown
problems           errors
requests           what is asked of the hardware
analysis_requests  what is asked of stored data and of plans
fits               fits of a frame, a file, many files; the ledger
derived            what follows from fits
sliding            fits along one ring-down
harmonics          what the harmonics of one shot tell
predictions        what a planned measurement can tell
acquisitions       series of shots
calibrations       calibrations, and which are in use
recordings         recordings, and dm/dt for a plot
models             adopted models
diagnosis          what a model lacks
live_diagnosis     the log of a diagnosis on the platform
platform           devices, state, self-test, resonators, the daemon
jobs               long work
job_records        the same on disk

REST, files and the command line all write these; OpenAPI shows them.  Times are ISO 8601, values SI with the unit in
their name.
"""

from __future__ import annotations

from .acquisitions import (
    AcquisitionResult,
    AcquisitionSummary,
    SeriesReport,
    SettleCheck,
    ShotSummary,
)
from .analysis_requests import (
    AdoptionRequest,
    DiagnosisRequest,
    PredictionRequest,
    RecordingFitRequest,
    RecordingPart,
    RetirementRequest,
)
from .base import (
    NoResult,
    Request,
    Root,
    Schema,
    Verdict,
    Window,
    to_json,
)
from .calibrations import (
    AnyCalibrationReport,
    CalibrationName,
    CalibrationReport,
    CalibrationsInUse,
    ComplexTable,
    ReceiveCalibrationReport,
    TransmitCalibrationReport,
)
from .derived import (
    AllanReport,
    DerivedReport,
    EnvelopesReport,
    FittedFrameQuantities,
    FrameQuantities,
    OrientationDeviation,
    OrientationErrors,
    SeriesQuantities,
    UnfittedFrameQuantities,
)
from .diagnosis import (
    DataDefect,
    DiagnosisReport,
    DiagnosisVerdict,
    EffectDetail,
    EffectStrength,
    HeldOutErrors,
    MeanParameter,
    MissingTorqueMap,
    NamedEffect,
    NextMeasurement,
    TriedEffect,
    UnexplainedRest,
    WindowDisagreement,
)
from .fits import (
    ErrorSummary,
    FileError,
    FileState,
    FitBatch,
    FitReport,
    FrameFit,
    LedgerLine,
    NoiseReport,
    ParameterEstimate,
    ParameterSummary,
    unfitted,
)
from .harmonics import (
    AnyHarmonicEstimate,
    HarmonicEstimate,
    HarmonicsBatch,
    HarmonicsReport,
    RefusedHarmonicEstimate,
    ShotHarmonics,
)
from .job_records import (
    AcquisitionRecord,
    CalibrationRecord,
    DiagnosisRecord,
    FitRecord,
    JobRecord,
    JobTimes,
    StoredJob,
)
from .jobs import (
    AcquisitionJob,
    AcquisitionJobs,
    CalibrationJob,
    CalibrationJobs,
    DiagnosisJob,
    DiagnosisJobs,
    FitJob,
    FitJobs,
    Job,
    JobState,
    Progress,
)
from .live_diagnosis import (
    DiagnosedRound,
    EffectSummary,
    LiveDiagnosisLog,
    ManualStep,
    UndiagnosedRound,
)
from .models import (
    AdoptedModelListing,
    AdoptedModelRecord,
    AdoptedModelReport,
    AdoptedModelSummary,
    AdoptedTermRecord,
    AdoptionEvidence,
    FileDigest,
    ModelListing,
    ReceiverEffectRecord,
    Retirement,
)
from .parameters import (
    PAPER_DEFLECTION_DEG,
    PAPER_NOISE_AM2_PER_S,
    PARAMETERS,
    RODRIGUES,
    ParameterDefinition,
    definition_of,
    names_in_order,
)
from .platform import (
    AmplifierState,
    AmplifierStatusReport,
    DeviceError,
    DeviceIdentity,
    DeviceListing,
    DeviceReadback,
    DeviceReport,
    DeviceSurvey,
    EntryPoints,
    FaultReset,
    Health,
    IoCardState,
    IoCardStatus,
    LnaState,
    LnaStatus,
    NoState,
    PlatformStatus,
    Readiness,
    ResonatorInfo,
    ResonatorListing,
    SelfTestReport,
    StopReport,
    SwitchState,
    SwitchStatus,
    ThermometerState,
)
from .predictions import (
    PredictionReport,
    WindowPrecision,
)
from .problems import (
    ErrorRecord,
    Problem,
    ProblemKind,
)
from .recordings import (
    CalibrationInfo,
    DmdtSeries,
    ExcitationInfo,
    FrameDescription,
    FrequencyResponseExtent,
    RecordingInfo,
    RecordingLinks,
    RecordingListing,
    RecordingSummary,
    ShotWindows,
    UnreadableRecording,
    WindowLength,
)
from .requests import (
    CALIBRATION_ID,
    AcquisitionRequest,
    ActivationRequest,
    CalibrationRequest,
    SelfTestOptions,
    SequencePatch,
    SequencePreset,
)
from .sliding import (
    FlatnessReport,
    SlidingReport,
    WindowFitReport,
)

__all__ = [  # noqa: RUF022
    "AcquisitionJob", "AcquisitionJobs", "AcquisitionRecord", "AcquisitionRequest", "AcquisitionResult",
    "AcquisitionSummary", "ActivationRequest", "AdoptedModelListing", "AdoptedModelRecord", "AdoptedModelReport",
    "AdoptedModelSummary", "AdoptedTermRecord", "AdoptionEvidence", "AdoptionRequest", "AllanReport",
    "AmplifierState", "AmplifierStatusReport", "AnyCalibrationReport", "AnyHarmonicEstimate", "CALIBRATION_ID",
    "CalibrationInfo", "CalibrationJob", "CalibrationJobs", "CalibrationName", "CalibrationRecord",
    "CalibrationReport", "CalibrationRequest", "CalibrationsInUse", "ComplexTable", "DataDefect", "DerivedReport",
    "DeviceError", "DeviceIdentity", "DeviceListing", "DeviceReadback", "DeviceReport", "DeviceSurvey",
    "DiagnosedRound", "DiagnosisJob", "DiagnosisJobs", "DiagnosisRecord", "DiagnosisReport", "DiagnosisRequest",
    "DiagnosisVerdict", "DmdtSeries", "EffectDetail", "EffectStrength", "EffectSummary", "EntryPoints",
    "EnvelopesReport", "ErrorRecord", "ErrorSummary", "ExcitationInfo", "FaultReset", "FileDigest", "FileError",
    "FileState", "FitBatch", "FitJob", "FitJobs", "FitRecord", "FitReport", "FittedFrameQuantities",
    "FlatnessReport", "FrameDescription", "FrameFit", "FrameQuantities", "FrequencyResponseExtent",
    "HarmonicEstimate", "HarmonicsBatch", "HarmonicsReport", "Health", "HeldOutErrors", "IoCardState",
    "IoCardStatus", "Job", "JobRecord", "JobState", "JobTimes", "LedgerLine", "LiveDiagnosisLog", "LnaState",
    "LnaStatus", "ManualStep", "MeanParameter", "MissingTorqueMap", "ModelListing", "NamedEffect",
    "NextMeasurement", "NoResult", "NoState", "NoiseReport", "OrientationDeviation", "OrientationErrors",
    "PAPER_DEFLECTION_DEG", "PAPER_NOISE_AM2_PER_S", "PARAMETERS", "ParameterDefinition", "ParameterEstimate",
    "ParameterSummary", "PlatformStatus", "PredictionReport", "PredictionRequest", "Problem", "ProblemKind",
    "Progress", "RODRIGUES", "Readiness", "ReceiveCalibrationReport", "ReceiverEffectRecord", "RecordingFitRequest",
    "RecordingInfo", "RecordingLinks", "RecordingListing", "RecordingPart", "RecordingSummary",
    "RefusedHarmonicEstimate", "Request", "ResonatorInfo", "ResonatorListing", "Retirement", "RetirementRequest",
    "Root", "Schema", "SelfTestOptions", "SelfTestReport", "SequencePatch", "SequencePreset", "SeriesQuantities",
    "SeriesReport", "SettleCheck", "ShotHarmonics", "ShotSummary", "ShotWindows", "SlidingReport", "StopReport",
    "StoredJob", "SwitchState", "SwitchStatus", "ThermometerState", "TransmitCalibrationReport", "TriedEffect",
    "UndiagnosedRound", "UnexplainedRest", "UnfittedFrameQuantities", "UnreadableRecording", "Verdict", "Window",
    "WindowDisagreement", "WindowFitReport", "WindowLength", "WindowPrecision", "definition_of", "names_in_order",
    "to_json", "unfitted",
]  # fmt: skip

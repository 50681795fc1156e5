"""What crosses a boundary: requests, results, jobs, problems, and the table of parameters with symbol and unit.

AcquisitionResult: What a series has brought so far.
AcquisitionSummary: A series as it would be.
SeriesReport: What `measure --json` writes.
SettleCheck: How much of the swing remains when the next shot begins, by the expected damping.
ShotSummary: One shot as it would be played.
AdoptionRequest: Adoption of what a diagnosis names.
DiagnosisRequest: A diagnosis of one specimen.
PredictionRequest: A planned measurement, of which the smallest standard deviations are asked.
RecordingFitRequest: A fit of a stored recording.
RetirementRequest: A version of an adopted model is taken out of use.
NoResult: There is no result.
Root: Something whose JSON is a list, a mapping, or one of several schemas.
to_json: The JSON text of files and of the command line.
CalibrationName: Name and date of a calibration.
CalibrationReport: What a calibration has found.
CalibrationsInUse: The calibrations that the next series is made with.
ComplexTable: A measured complex table in the unit of its key.
ReceiveCalibrationReport: What a calibration of the receive side has found (paper eq:u(t,p,R)).
TransmitCalibrationReport: What a calibration of the transmit side has found.
DerivedReport: Derived quantities of a fit.
EnvelopesReport: Envelopes of a fitted frame over its window.
DiagnosisReport: What the declared model lacks.
FitReport: The fits of one file.
ShotHarmonics: What the harmonics of one shot tell, or why they cannot be read.
AnyJobRecord: The record of a job of one of the four kinds.
JobTimes: When a job was asked for, began and ended, ISO 8601.
StoredJob: The record of a job of any kind.
AcquisitionJob: A series of shots.
AcquisitionJobs: All acquisitions, oldest first.
CalibrationJob: A calibration.
CalibrationJobs: All calibrations, oldest first.
DiagnosisJob: A diagnosis.
DiagnosisJobs: All diagnoses, oldest first.
FitJob: A fit of a stored recording.
FitJobs: All fits, oldest first.
JobState: queued -> running -> done | failed | cancelled.
Progress: How far a job is.
AdoptedModelRecord: A named, versioned model with the evidence for it.
AdoptedModelReport: An adopted model, and whether it is still in use.
AdoptedModelSummary: One line of the list of adopted models.
ModelListing: What a fit can use.
AmplifierState: State of the power amplifier.
DeviceError: The last thing that went wrong with a device.
DeviceListing: Every device of the platform, also one that does not answer.
DeviceReadback: A device as last read back.
DeviceReport: One device.
DeviceSurvey: What `devices --json` writes.
EntryPoints: Where everything is.
FaultReset: What the latched fault of the power amplifier was, and the amplifier after its reset.
Health: The daemon is alive.
PlatformStatus: The platform as last read back.
Readiness: Whether every part has warmed up.
ResonatorInfo: A resonator that can be measured.
ResonatorListing: Resonators by the name to use in an acquisition.
SelfTestReport: What the self-test before a series has heard of every coil through the open receive contacts.
StopReport: What was stopped.
PredictionReport: How precise a planned measurement can be at best, per window.
ErrorRecord: An error as the record of a job keeps it.
Problem: What went wrong, where and why, and what to do about it (RFC 9457, `application/problem+json`).
ProblemKind: What a kind of problem means.
CalibrationInfo: The receive calibration of a recording (paper eq:u(t,p,R)).
DmdtSeries: Calibrated dm/dt of one frame for a plot.
ExcitationInfo: What a shot was excited with.
FrameDescription: One frame of a recording.
FrequencyResponseExtent: Where the frequency response of a calibration is known.
RecordingInfo: What a recording holds.
RecordingLinks: Where the parts of a recording are.
RecordingListing: Everything in the folder of recordings, by name.
RecordingSummary: One line of the list of recordings.
ShotWindows: The three windows of a shot, one after the other.
UnreadableRecording: A file that looks like a recording but cannot be used.
WindowLength: Length of one window of a shot.
AcquisitionRequest: A series of shots on one resonator.
ActivationRequest: A calibration to use from the next series on.
CalibrationRequest: A calibration of the receive side with a reference dipole, or of the transmit side with a field
    probe.
SelfTestOptions: The self-test before a series, table `[self_test]` of a platform file.
SequencePatch: The keys of a sequence that differ from the resonator's preset.
SequencePreset: One shot and how often it is repeated (paper, tab:measurement_parameter).
SlidingReport: Fits along one ring-down.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""What crosses a boundary: requests, results, jobs, problems, and the table of parameters with symbol and unit.

TOKEN_NAME: What a token can be called, as a regular expression.
AuditEntry: One line of the audit log.
Confirmation: What a request holds that needs no values.
Role: What the holder of a token may do.
TokenRecord: A token as its file keeps it.
TokenRecords: The file of the tokens.
AcquisitionResult: What a series has brought so far.
AcquisitionSummary: A series as it would be.
SeriesReport: What `measure --json` writes.
SettleCheck: How much of the swing remains when the next shot begins, by the expected damping.
ShotPage: Some shots of an acquisition.
ShotReport: One shot on disk, and its on-line fit.
ShotSummary: One shot as it would be played.
Acknowledgement: Somebody knows of an alarm.
Alarm: One thing that somebody should know.
AlarmListing: All alarms.
Alarms: The file of the alarms.
AdoptionRequest: Adoption of what a diagnosis names.
DefectsRequest: A manufacturing defect in some sizes, at some deflections.

DiagnosisRequest: A diagnosis of one specimen.
PredictionRequest: A planned measurement, of which the smallest standard deviations are asked.
RecordingFitRequest: A fit of a stored recording.
RetirementRequest: A version of an adopted model is taken out of use.
NamedWindow: An evaluation window with a name: n50 or d30.
NoResult: There is no result.
Root: Something whose JSON is a list, a mapping, or one of several schemas.
Schema: Something that crosses a boundary.
Window: An evaluation window: n50, d30 or seconds.
to_json: The JSON text of files and of the command line.
CalibrationName: Name and date of a calibration.
CalibrationReport: What a calibration has found.
CalibrationsInUse: The calibrations that the next series is made with.
ComplexTable: A measured complex table in the unit of its key.
ReceiveCalibrationReport: What a calibration of the receive side has found (paper eq:u(t,p,R)).
TransmitCalibrationReport: What a calibration of the transmit side has found.
SIGNIFICANCE: Level of significance of the paper (ssec:primary_results).
CharacterisationReport: What `characterise --json` writes.
CharacterisationRequest: A characterisation of one resonator from shots that are stored.
CharacteriseOutcome: What characterise has made of its shots.
CharacteriseRequest: Many shots of one resonator in one recording, and the paper's tables from them.
FitDataset: The fits of all shots over one window.
OrientationReference: The best D30 fit.
ParameterStatistics: A fitted parameter over the good shots.
ParameterUncertainty: What a D30 fit of one shot is good for.
QualityFactors: Quality factors over the good shots (tab:quality_factors).
RefusedShots: Shots without a fit, for one reason.
ShotStatistics: A quantity over the shots that have it, in the unit that its name holds.
WindowComparison: A quantity in N50 against the same in D30, shot by shot.
AllanReport: Overlapping Allan deviation of f_nat with its confidence interval of 68.3 % (NIST SP 1065).
DerivedReport: Derived quantities of a fit.
EnvelopesReport: Envelopes of a fitted frame over its window.
FittedFrameQuantities: Quality factors of a good frame, with its number.
FrameQuantities: Quality factors of one good frame.
FrequencyNoise: Power law of the noise of a frequency.
OrientationDeviation: Angles between the orientations of a series and one of reference.
OrientationErrors: Orientation errors of a series with a calibration.
SeriesQuantities: What the frames of a series tell together.
UnfittedFrameQuantities: A frame without a fit.
DefectCase: A defect of one size at one deflection.
DefectsReport: Equivalent perpendicular force of a manufacturing defect.
DesignReport: What follows from magnets and bearing alone.
FrictionReport: Dry friction of a jewel bearing by design.
MagnetValues: The two spheres.
MeasuredValues: What was measured on the specimen and overrides its design.
PrintedFriction: Friction as the paper prints it, which does not follow from the mu that it prints.
ProcedureStep: A step of the paper's six.
StaticProcedure: From a manufacturing error to its perpendicular force in six steps.
DataDefectReport: Something in the data that is not as it should be.
DefectKind: What can be wrong with the data themselves.
DiagnosisReport: What the declared model lacks.
DiagnosisVerdict: How far a diagnosis explains its data.
EffectDetail: Where an effect acts.
EffectStrength: How strong an effect is.
HeldOutErrors: Errors of the prediction of data that were not used.
MeanParameter: Mean of a parameter over the shots, in the SI unit that its name holds.
MissingTorqueMap: The torque that is missing, smooth in angle and velocity, without what declared parameters absorb.
MovingParameter: A constant of the declared model that is none along the ring-down.
NamedEffect: An accepted effect with its evidence.
NextMeasurement: A measurement that tells more.
ParameterTrace: A parameter along the ring-down of shots that start alike, to first order.
TentativeEffect: An effect that gains, and was not accepted.
TriedEffect: A candidate by itself beside the declared model.
UnexplainedRest: What something without a name would still bring.
WindowDisagreement: How far fits of a short window (N50) and of a long one (D30) disagree.
BLANK: Why a blank shot is not fitted.
AlarmEvent: Somebody should know, or has said that he does.
AnyHappening: What an event can say.
DeviceEvent: A device has stopped to answer, or answers again.
DroppedEvent: Events that a listener will not get.
Event: Something that has happened.
EventKind: Kinds of events.
FitEvent: The on-line fit of a shot.
InterlockEvent: The interlock has closed, or is open again.
JobEvent: A job was queued, has begun, or has ended.
ScheduleEvent: A row of the ledger of a schedule has changed.
ShotEvent: A shot is on disk.
ErrorSummary: An error in a list of results.
FileError: A file that could not be read or fitted at all.
FileDigest: A file and what identifies its content.
FileState: What tells that a file has changed.
FitBatch: The fits of several files, in the order in which they were named.
FitReport: The fits of one file.
FrameFit: The fit of one frame, or why it was refused.
LedgerLine: One line of the ledger of a batch (`fit --jsonl`).
NoiseReport: Where the noise of a fit was measured.
ParameterEstimate: An estimated parameter, in the SI unit that its name holds.
ParameterSummary: A parameter over the good frames of a series, in the SI unit that its name holds.
unfitted: A frame that could not even be offered to the fit.
HarmonicEstimate: Frequency, amplitude, moment, orientation and decay in the first 24 periods.
HarmonicsBatch: The same of several files, in the order in which they were named.
HarmonicsReport: What the harmonics of the frames of one file tell.
RefusedHarmonicEstimate: The harmonics cannot be read.
ShotHarmonics: What the harmonics of one shot tell, or why they cannot be read.
AnyQueuedRequest: What can wait for the platform.
AnyJobRecord: A job as its file keeps it, of any kind.
JobTimes: When a job was asked for, began and ended, ISO 8601.
StoredJob: The record of a job of any kind.
AcquisitionJob: A series of shots.
AcquisitionJobs: All acquisitions, oldest first.
CalibrationJob: A calibration.
CalibrationJobs: All calibrations, oldest first.
SelfTestJob: A self-test.
SelfTestJobs: All self-tests, oldest first.
SelfTestRequest: A self-test now.
CharacterisationJob: A characterisation.
CharacterisationJobs: All characterisations, oldest first.
DiagnosisJob: A diagnosis.
DiagnosisJobs: All diagnoses, oldest first.
FitJob: A fit of a stored recording.
FitJobs: All fits, oldest first.
JobState: queued -> running -> done | failed | cancelled.
ProcedureJob: A procedure.
ProcedureJobs: All procedures, oldest first.
Progress: How far a job is.
QueuedJob: One that waits for the platform.
DiagnosedRound: A series, and what it brought to the diagnosis.
EffectSummary: An accepted effect in short.
JobSnapshot: A job as it is at one moment.
LinkAnswer: The answer to one call over the local socket.
LinkCall: A question or a command over the local socket.
LinkError: An error on its way to the process that has asked.
LiveDiagnosisLog: What a loop on the platform measured, why, and what it brought.
ManualStep: A step that needs a hand and was not done.
UndiagnosedRound: A series that was cut short, or after which nothing could be diagnosed.
AdoptedModelListing: Every version of every adopted model, by name and version.
AdoptedModelRecord: A named, versioned model with the evidence for it.
AdoptedModelReport: An adopted model, and whether it is still in use.
AdoptedModelSummary: One line of the list of adopted models.
AdoptedTermRecord: A further torque term of an adopted model.
AdoptionEvidence: What is kept with an adopted model so that anybody can judge it, or repeat the diagnosis.
ModelListing: What a fit can use.
ReceiverEffectRecord: An effect of the receive chain that an adopted model undoes in the samples before a fit.
Retirement: Who took a version out of use, when and why.
PAPER_DEFLECTION_DEG: Deflection at the paper's fields by bearing, degrees.
PAPER_NOISE_AM2_PER_S: Noise of x, y, z per sample in the paper, A m^2/s.
PARAMETERS: The table of parameters by name.
ParameterDefinition: One parameter.
RODRIGUES: Names of the three components of an orientation.
definition_of: Of a parameter.
names_in_order: Parameters of the table in the order in which they are told.
AmplifierState: State of the power amplifier.
MOST_STEPS: Of one sweep, or ramp.
printable: Text with control characters written out.
CatalogueEntry: A resonator or a sequence that was added.
DeviceError: The last thing that went wrong with a device.
DeviceListing: Every device of the platform, also one that does not answer.
DeviceReadback: A device as last read back.
DeviceReport: One device.
DeviceSurvey: What `devices --json` writes.
EntryPoints: Where everything is.
FaultCleared: What stood in the way of power, and who has cleared it.
FaultUnlock: Who clears the fault of an owner that has died, and why.
MountRequest: A resonator was put into the clamping unit.
MountedResonator: What is in the clamping unit, as far as anybody has said.
QueueOrder: The order of jobs that wait.
Checkup: What `doctor` found.
Finding: One thing that it has looked at.
Verdict: How that stands.
FaultReset: What the latched fault of the power amplifier was, and the amplifier after its reset.
Health: The daemon is alive.
PlatformStatus: The platform as last read back.
Readiness: Whether every part has warmed up.
ResonatorInfo: A resonator that can be measured.
ResonatorListing: Resonators by the name to use in an acquisition.
SelfTestReport: What the self-test before a series has heard of every coil through the open receive contacts.
SequenceListing: Sequences by the name to use as `preset` of an acquisition, with the keys that they set.
StopReport: What was stopped.
PredictionReport: How precise a planned measurement can be at best, per window.
WindowPrecision: The smallest standard deviations that an evaluation window can reach.
ErrorRecord: An error as the record of a job keeps it.
Problem: What went wrong, where and why, and what to do about it (RFC 9457, `application/problem+json`).
ProblemKind: What a kind of problem means.
UnreadableFile: A file that looks like what is listed but cannot be used.
AnyOutcome: What a procedure finds beside the results of its steps.
AnyProcedureRequest: A procedure that can be asked for.
PlannedStep: One step as it would be.
ProcedureLog: The log of a procedure on disk, written anew after every step, and what `sweep --json` writes.
ProcedureResult: What a procedure has brought so far.
ProcedureSummary: A procedure as it would be: every step is checked, nothing moves.
RingingLine: An oscillation in a shot, fitted or not.
StepEstimate: A result of a step over its good fits, in the unit that its name holds.
StepReport: One step as it was made.
SweptValue: A key of a step and its value.
CalibrationInfo: The receive calibration of a recording (paper eq:u(t,p,R)).
DmdtSeries: Calibrated dm/dt of one frame for a plot.
ExcitationInfo: What a shot was excited with.
FrameDescription: One frame of a recording.
FrequencyResponseExtent: Where the frequency response of a calibration is known.
RecordingInfo: What a recording holds.
RecordingLinks: Where the parts of a recording are.
RecordingListing: Everything in the folder of recordings, by name.
RecordingSummary: One line of the list of recordings.
RecoveryReport: What became of shots that were kept in single files.
ShotWindows: The three windows of a shot, one after the other.
WindowLength: Length of one window of a shot.
AcquisitionRequest: A series of shots on one resonator.
ActivationRequest: A calibration to use from the next series on.
CalibrationRequest: A calibration of the receive side with a reference dipole, or of the transmit side with a field
    probe.
SelfTestOptions: The self-test before a series, table `[self_test]` of a platform file.
SequencePatch: The keys of a sequence that differ from the resonator's preset.
SequencePreset: One shot and how often it is repeated (paper, tab:measurement_parameter).
AnyWorkRequest: A work that a schedule can start.
DiagnosisWorkRequest: A diagnosis of the newest recordings of a specimen.
FitWorkRequest: A fit of the newest recording of a specimen.
LedgerPage: Some rows of the ledger of a schedule.
LedgerRow: What became of one due instant.
Schedule: A schedule as it is.
ScheduleListing: All schedules.
SchedulePreview: When a schedule would start.
ScheduleRequest: A work that is started by the calendar.
TriggerRequest: When a schedule is due.
FlatnessReport: Do the windows agree on one value of a parameter? In the SI unit that its name holds.
SlidingReport: Fits along one ring-down.
WindowFitReport: The fit of one window.
StopRule: Ends a procedure after the first step whose result is so.
SweepAxis: One key of the acquisition and the values that it takes.
SweepRequest: A sweep: the same acquisition again and again, each step with other values of some keys.
RampLine: A line in the z residual.
RampOutcome: What a ramp has found so far.
RampRequest: Ramp: raise the field step by step until side modes show.
RampStep: One field of a ramp.
RampThreshold: Field at which the z residual passes the visible level.
Baseline: Since when a specimen is what it is now.
BaselineRequest: A specimen is accepted as it is.
Baselines: The file of the baselines.
ChangeName: What a change is taken for.
SpecimenListing: Specimens with recordings that were fitted.
SpecimenPage: What is known of a specimen.
SpecimenResonator: A resonator as which it was measured.
TrendChange: Something has changed by more than chance.
TrendChart: The control chart of one quantity.
TrendPoint: Shots of one recording that were made within ten minutes.
TrendReport: Months of a specimen.
TunedPreset: The sequence of a resonator that tune has found, as it is kept.
TuneOutcome: What tune has found so far.
TuneRequest: Tune: find the resonator's frequency, and how it is measured best.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

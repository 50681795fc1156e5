"""What crosses a boundary: requests, results, jobs, problems, and the table of parameters with symbol and unit.

AdoptionRequest: Adoption of what a diagnosis names.
DiagnosisRequest: A diagnosis of one specimen.
RetirementRequest: A version of an adopted model is taken out of use.
Root: Something whose JSON is a list, a mapping, or one of several schemas.
Schema: Something that crosses a boundary.
to_json: The JSON text of files and of the command line.
DataDefectReport: Something in the data that is not as it should be.
DefectKind: What can be wrong with the data themselves.
DiagnosisReport: What the declared model lacks.
DiagnosisVerdict: How far a diagnosis explains its data.
EffectDetail: Where an effect acts.
EffectStrength: How strong an effect is.
HeldOutErrors: Errors of the prediction of data that were not used.
MeanParameter: Mean of a parameter over the shots, in the SI unit that its name holds.
MissingTorqueMap: The torque that is missing, smooth in angle and velocity, without what declared parameters absorb.
NamedEffect: An accepted effect with its evidence.
NextMeasurement: A measurement that tells more.
TriedEffect: A candidate by itself beside the declared model.
UnexplainedRest: What something without a name would still bring.
WindowDisagreement: How far fits of a short window (N50) and of a long one (D30) disagree.
DiagnosedRound: A series, and what it brought to the diagnosis.
EffectSummary: An accepted effect in short.
LiveDiagnosisLog: What a loop on the platform measured, why, and what it brought.
ManualStep: A step that needs a hand and was not done.
UndiagnosedRound: A series that was cut short, or after which nothing could be diagnosed.
AdoptedModelListing: Every version of every adopted model, by name and version.
AdoptedModelRecord: A named, versioned model with the evidence for it.
AdoptedModelReport: An adopted model, and whether it is still in use.
AdoptedModelSummary: One line of the list of adopted models.
AdoptedTermRecord: A further torque term of an adopted model.
AdoptionEvidence: What is kept with an adopted model so that anybody can judge it, or repeat the diagnosis.
FileDigest: A file and what identifies its content.
ModelListing: What a fit can use.
ReceiverEffectRecord: An effect of the receive chain that an adopted model undoes in the samples before a fit.
Retirement: Who took a version out of use, when and why.
definition_of: Of a parameter.
SelfTestOptions: The self-test before a series, table `[self_test]` of a platform file.
SequencePatch: The keys of a sequence that differ from the resonator's preset.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

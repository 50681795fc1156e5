"""From the residual of measured ring-downs to the effect that the model lacks, with proof by held-out data.

Diagnosis: Everything that was found out, for reports.
DiagnosisError: The shots cannot be diagnosed.
diagnose_shots: Diagnose shots of one specimen that all obey the same declared model.
MissingTorque: Torque per inertia in rad/s^2 on a grid of angles (n,) in rad and velocities (m,) in rad/s.
Measurement: A measurement that separates effects.
Proposal: A measurement, the ids it separates, and the difference it is expected to show, in standard deviations.
HARMONICS: Harmonics whose course the analysis of a residual follows.
HarmonicCourse: Harmonics 1 ..
ResidualAnalysis: What is left of one shot.
Scatter: One parameter from shot to shot.
analyse_residual: Of shot k.
scatter: Parameters from shot to shot, with their drift along the series.
sliding_windows: Fits along shot k with the effects held.
typical_shot: The shot whose residual is in the middle of all.
as_json: The fixed form.
DataDefect: Something that is not as it should be.
ProgressCallback: What a diagnosis calls to tell how far it is: (what it does, share done).
DiagnosisShot: A ring-down with its measured noise.
shot_pool: A thread per core.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""From the residual of measured ring-downs to the effect that the model lacks, with proof by held-out data.

Diagnosis: Everything that was found out, for reports.
DiagnosisError: The shots cannot be diagnosed.
diagnose: Diagnose shots of one specimen that all obey the same declared model.
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

from .diagnose import Diagnosis, DiagnosisError, diagnose
from .findings.missing_torque import MissingTorque
from .findings.next_measurements import Measurement, Proposal
from .findings.residual_analysis import (
    HARMONICS,
    HarmonicCourse,
    ResidualAnalysis,
    Scatter,
    analyse_residual,
    scatter,
    sliding_windows,
    typical_shot,
)
from .report import as_json
from .selection.data_integrity import DataDefect
from .selection.stepwise import ProgressCallback
from .shots.shot import DiagnosisShot
from .shots.thread_pool import shot_pool

__all__ = [
    "HARMONICS",
    "DataDefect",
    "Diagnosis",
    "DiagnosisError",
    "DiagnosisShot",
    "HarmonicCourse",
    "Measurement",
    "MissingTorque",
    "ProgressCallback",
    "Proposal",
    "ResidualAnalysis",
    "Scatter",
    "analyse_residual",
    "as_json",
    "diagnose",
    "scatter",
    "shot_pool",
    "sliding_windows",
    "typical_shot",
]

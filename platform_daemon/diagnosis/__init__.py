"""From the residual of measured ring-downs to the effect that the model lacks, with proof by held-out data.

Diagnosis: Everything that was found out, for reports.
DiagnosisError: The shots cannot be diagnosed.
diagnose_shots: Diagnose shots of one specimen that all obey the same declared model.
Measurement: A measurement that separates effects.
Proposal: A measurement, the ids it separates, and the difference it is expected to show, in standard deviations.
HARMONICS: Harmonics whose course the analysis of a residual follows.
HarmonicCourse: Harmonics 1 ..
ResidualAnalysis: What is left of one shot.
Scatter: One parameter from shot to shot.
diagnosis_report: The fixed report, without the files, which the diagnosis does not know.
ResidualComparison: The residual with the declared model (before) and with the named effects (after).
SlidingComparison: Fits along one shot with the declared model and with the named effects.
compare_residuals: Takes about a second.
DataDefect: Something that is not as it should be.
ProgressCallback: What a diagnosis calls to tell how far it is: (what it does, share done).
DiagnosisShot: A ring-down with its measured noise.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

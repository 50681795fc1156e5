"""From the residual of measured ring-downs to the effect that the model lacks, with proof by held-out data.

One diagnosis meets each room once: shots.py (what is looked at) - start.py (fits of the declared model) - integrity.py
(flaws of the data) - look.py, refit.py (joint fits of all shots) - scan.py, picture.py, sets.py, signs.py, search.py
(score tests, sets of effects) - heldout.py (proof) - lookalikes.py, proposals.py (what cannot be told apart, what
would) - missing_torque.py (what has no name) - diagnose.py (the whole) - report.py. effects/ holds one module per kind.
"""

from .diagnose import Diagnosis, DiagnosisError, diagnose
from .report import as_json
from .shots.shot import DiagnosisShot

__all__ = ["Diagnosis", "DiagnosisError", "DiagnosisShot", "as_json", "diagnose"]

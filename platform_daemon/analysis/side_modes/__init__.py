"""Side modes: what of them the z channel shows, whether they show at all, and at which field they begin.

escalation: The next field of a ramp: as high as overdose control allows, never more than a step, and again where in
    doubt.
onset_test: Whether side modes are visible at a field, tested shot by shot, right at any stopping time.
recorded: The z residuals of recorded shots, each a file of its own while its series runs.
threshold: Where the z residual passes the visible level, as far as the shots so far tell.
z_residual: What a shot shows out of the plane of the main mode, freed from noise and hum.
"""

from .escalation import Escalation, RampPlan
from .onset_test import OnsetTest
from .recorded import RecordedSideModes
from .threshold import ThresholdPosterior
from .z_residual import VISIBLE_AM2_PER_S, SideLine, ZNoise, ZResidual, z_residual

__all__ = [
    "VISIBLE_AM2_PER_S", "Escalation", "OnsetTest", "RampPlan", "RecordedSideModes", "SideLine", "ThresholdPosterior",
    "ZNoise", "ZResidual", "z_residual",
]  # fmt: skip

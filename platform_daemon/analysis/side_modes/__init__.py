"""Side modes: what of them the z channel shows, whether they show at all, and at which field they begin.

ZResidual: What a shot shows out of the plane of the main mode.
z_residual: Of one shot, against the noise of shots at low amplitude.
ZNoise: The power of the z residual where nothing moves but the main mode.
SideLine: A line in the z residual.
VISIBLE_AM2_PER_S: Largest |z residual| from which side modes count as visible.
OnsetTest: A sequential test whether side modes are visible, right at any stopping time.
ThresholdPosterior: Where the z residual passes the visible level, as far as the shots so far tell.
RampPlan: What a ramp may do.
Escalation: The state of one ramp, and its next field.
RecordedSideModes: What recorded shots show out of the plane.
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

"""Time and amplitude in a swing that dies: what depends on the one imitates what depends on the other."""

from __future__ import annotations

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS


def same_swing(at: JointFit) -> bool:
    """No two shots pass the same amplitude at different times, which would part the two."""
    sizes = [abs(s.dynamics.amplitude) for s in at.states]
    return max(sizes) < THRESHOLDS.findings.group_ratio * min(sizes)


def timed_torques(at: JointFit) -> bool:
    """A torque depends on time."""
    return any(c.term is not None and c.term.timed for c in at.hypothesis.effects)

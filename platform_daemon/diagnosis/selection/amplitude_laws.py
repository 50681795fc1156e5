"""Time and amplitude in a swing that dies: what depends on the one imitates what depends on the other.

An exponential of free rate has the course of a power of an amplitude that dies exponentially.
"""

from __future__ import annotations

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.torque import SPRINGS
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS


def time_is_doubtful(at: JointFit) -> bool:
    """No two shots pass the same amplitude at different times, and what is left is no noise, which would decide."""
    sizes = [abs(s.dynamics.amplitude) for s in at.states]
    if max(sizes) > THRESHOLDS.findings.group_ratio * min(sizes) or _die_differently(at):
        return False
    return at.chi2_per_dof >= THRESHOLDS.regression.noise_chi2_per_dof


def _die_differently(at: JointFit) -> bool:
    """One shot is damped so much more than another one that the same time is another amplitude."""
    names = [c.name for c in at.hypothesis.model.coefficients]
    if "lambda_per_s" not in names:
        return False
    rates = [s.dynamics.values[names.index("lambda_per_s")] for s in at.states]
    return 0.0 < THRESHOLDS.selection.parting_rates * min(rates) < max(rates)


def timed_torques(at: JointFit) -> bool:
    """A torque depends on time."""
    return any(map(is_timed, at.hypothesis.effects))


def is_timed(c: Candidate) -> bool:
    """It is a torque that depends on time."""
    return c.term is not None and c.term.timed


def laws_of_amplitude(at: JointFit) -> bool:
    """A restoring torque changes with the amplitude, and none with time."""
    return not timed_torques(at) and any(c.effect.id in SPRINGS for c in at.hypothesis.effects)

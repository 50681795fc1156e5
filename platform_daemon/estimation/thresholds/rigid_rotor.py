"""Tuned numbers of the rotor of five degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import tuned

AGREEMENT = "tests/estimation/physics/rigid_rotor/test_rotor.py"


@dataclass(frozen=True, kw_only=True)
class RigidRotorThresholds:
    """How finely its motion is computed, and how it is fitted."""

    first_step: float = tuned(0.1, "samples", "first trial of a step")
    safety: float = tuned(0.9, "1", "of the step that would just meet the tolerance")
    shrink: float = tuned(0.2, "1", "least ratio of a step to the one before")
    grow: float = tuned(5.0, "1", "largest ratio of a step to the one before")
    shortest_step_s: float = tuned(1e-13, "s", "below which the motion cannot be followed")
    tolerance: float = tuned(
        1e-9, "1", "error per step of the swing, of 1 for directions and of omega_nat for speeds", AGREEMENT
    )
    side_factor: float = tuned(10.0, "1", "times that for what is not the swing", AGREEMENT)
    rest_rounds: int = tuned(25, "rounds", "of Newton's method for the position of rest")
    rest_step: float = tuned(1e-6, "rad", "of its differences")
    rest_close: float = tuned(1e-11, "rad", "step at which it ends")
    rest_farthest: float = tuned(
        0.8, "1", "displacement of the held point over its link, beyond which there is no rest"
    )
    creep_spin_rad_per_s: float = tuned(
        3e-4, "rad/s", "spin below which a jewel's contact creeps: a millionth of the main mode's speed"
    )

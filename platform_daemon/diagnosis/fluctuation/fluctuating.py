"""What may fluctuate along a ring-down: the dry friction of a bearing, or the natural frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.effects.effect import Effect
from platform_daemon.diagnosis.effects.fluctuation import FREQUENCY_FLUCTUATION, FRICTION_FLUCTUATION
from platform_daemon.diagnosis.findings.knot_responses import F_NAT, Moving
from platform_daemon.diagnosis.regression.start_changes import W
from platform_daemon.diagnosis.shots.torque_course import dry_friction, friction_law
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torques.torque_course import SINE

from .process import CourseProcess

_LIMITS = THRESHOLDS.fluctuation
_FIRST_COEFFICIENT = 3  # place in the parameters of a state


@dataclass(frozen=True, kw_only=True)
class Fluctuating:
    """What has another course in every shot.

    Attributes:
        effect: its name, and the unit of its size.
        moving: the parameter of the declared model that moves.
        law: of the torque that this changes, see `estimation.physics.torques.torque_course`.
        largest: size that is sought.
        knots: of a course.
        most_shots: whose courses are fitted.
        noun: in words.
    """

    effect: Effect
    moving: Moving
    law: float
    largest: float
    knots: int
    most_shots: int
    noun: str

    def unit(self, states: Sequence[FitState]) -> float:
        """Torque per inertia, rad/s^2, that a size of 1 stands for: the mean friction, or what 1 Hz adds to w^2."""
        if self.effect is FRICTION_FLUCTUATION:
            return self.unit_of_parameter(states)
        return 2.0 * self.unit_of_parameter(states) * float(np.mean([s.dynamics.w for s in states]))

    def unit_of_parameter(self, states: Sequence[FitState]) -> float:
        """By how much a size of 1 moves the parameter: the mean friction (its size, where a poor fit has it negative),
        or 2 pi rad/s."""
        if self.effect is FRICTION_FLUCTUATION:
            place = self.moving.place - _FIRST_COEFFICIENT
            return abs(float(np.mean([s.dynamics.values[place] for s in states])))
        return 2.0 * math.pi

    def pumped_per_s(self, process: CourseProcess, states: Sequence[FitState]) -> float:
        """Variance that the logarithm of the amplitude gains per second by what is faster than any knots.

        A frequency that changes by d(t), rad/s, pumps the amplitude by d ln A / dt = d sin(2 psi): where d has the
        one-sided density S at twice the frequency, ln A walks by S / 4 per second.  S is that of the process, far
        beyond what the knots show of it, and counts so many times as is in `pumped_times`.  A friction does not pump.
        """
        if self.effect is FRICTION_FLUCTUATION:
            return 0.0
        rate = 2.0 * float(np.mean([s.dynamics.w for s in states]))
        quarter = (2.0 * math.pi * process.size) ** 2 * process.tau_s / (1.0 + (rate * process.tau_s) ** 2)
        return _LIMITS.pumped_times * quarter


def what_may_fluctuate(model: RingDownModel) -> tuple[Fluctuating, ...]:
    """Of a bearing with dry friction that first, then the frequency, for its contact wanders; of any other nothing."""
    name = dry_friction(model)
    if name is None:
        return ()
    place = _FIRST_COEFFICIENT + [c.name for c in model.coefficients].index(name)
    return (
        Fluctuating(
            effect=FRICTION_FLUCTUATION,
            moving=Moving(name, place),
            law=friction_law(model),
            largest=_LIMITS.largest_share,
            knots=_LIMITS.knots,
            most_shots=_LIMITS.most_shots,
            noun="friction",
        ),
        Fluctuating(
            effect=FREQUENCY_FLUCTUATION,
            moving=Moving(F_NAT, W),
            law=SINE,
            largest=_LIMITS.largest_hz,
            knots=_LIMITS.knots_of_frequency,
            most_shots=_LIMITS.most_shots_of_frequency,
            noun="natural frequency",
        ),
    )

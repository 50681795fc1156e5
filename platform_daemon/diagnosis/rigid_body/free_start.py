"""Where a motion begins of which no drive is known, as its first periods show it."""

from __future__ import annotations

import itertools
import math
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import STARTS, LostRotorError, NoRestError, RotorValues
from platform_daemon.estimation.rotor_fit.fit import RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot

_LIMITS = THRESHOLDS.rigid_body


def begun_freely(shot: RotorShot, values: RotorValues) -> RotorValues:
    """These values, with the angle and the speed at the first sample that leave least of the first periods.

    One angle tells both with an orientation and a moment that an error makes wrong; here they are those of `values`.
    The swing's size follows from the power, since in its plane dm/dt is m_r times the speed.
    """
    w = 2.0 * math.pi * values.f_nat_hz
    part = _first_periods(shot, values)
    power = float(np.sum(part.samples.var(axis=1) - shot.sd**2))
    size = math.sqrt(2.0 * max(power, 0.0)) / (values.m_r_am2 * w)
    phases = 2.0 * np.pi * np.arange(_LIMITS.free_start_phases) / _LIMITS.free_start_phases
    tried = []
    for phase, factor in itertools.product(phases.tolist(), _LIMITS.free_start_sizes):
        begun = replace(
            values,
            start_angle_rad=factor * size * math.cos(phase),
            start_speed_rad_per_s=factor * size * w * math.sin(phase),
        )
        tried.append((left_over(part, begun), begun))
    return min(tried, key=lambda one: one[0])[1]


def settled_start(shot: RotorShot, values: RotorValues, pool: Executor) -> RotorValues:
    """These values with the whole state at the first sample, side modes as well, fitted to the first periods while all
    else is held.

    Side modes may begin with a tenth of the swing's speed.  Free together with the orientation and the moment they end
    in another minimum; of a few periods alone they are nearly linear.
    """
    free = free_parameters(shot.geometry, DEFECTS, shot.start)
    held = [p.name for p in free if p.name not in STARTS]
    part = replace(_first_periods(shot, values), values=values)
    try:
        return fit_rotor([part], None, pool, first_window_s=math.inf, held=held, whole=False).values[0]
    except RotorFitError:
        return values


def _first_periods(shot: RotorShot, values: RotorValues) -> RotorShot:
    return replace(shot, samples=shot.samples[:, : shot.count(_LIMITS.free_start_periods / values.f_nat_hz)])


def left_over(shot: RotorShot, values: RotorValues) -> float:
    """chi^2; infinite where there is no such rotor."""
    try:
        residual = shot.residual(values, math.inf)
    except (NoRestError, LostRotorError):
        return math.inf
    return float(residual @ residual)

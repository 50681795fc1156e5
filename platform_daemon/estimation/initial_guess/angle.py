"""Start values of an angle record: turning points give amplitude and phase, their decline the losses.

Valid from six periods on, up to 170 degrees, for any loss that leaves two half cycles to be seen.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import AngleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.orbit import frequency_ratio
from platform_daemon.estimation.physics.torques.dispatch import acceleration
from platform_daemon.estimation.physics.torques.linear_restoring import LINEAR_RESTORING
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.screening.angle_cycles import HalfCycles, find_half_cycles
from platform_daemon.estimation.thresholds import THRESHOLDS

from .initial_state import InitialState

LIMITS = THRESHOLDS.start_values


def guess_initial_state_of_angle(
    record: RingDownRecord, model: RingDownModel, *, first: int, last: int, frequency_hz: float
) -> InitialState:
    """Start states at the turning points nearest to t = 0.

    Raises:
        RefusedError: no two half cycles stand out.
    """
    cycles = find_half_cycles(record.samples[0, first:last], first=first, dt_s=record.dt_s, frequency_hz=frequency_hz)
    if cycles is None:
        raise RefusedError(Refusal.TOO_SHORT, "fewer than two half cycles stand out")
    w = _natural_frequency(model, cycles)
    values = _losses(model, cycles, w)
    states = {s.dynamics.amplitude: s for s in _states(model, cycles, w, values)}
    periods = (cycles.passages_s[0] - first * record.dt_s) * frequency_hz + LIMITS.angle_periods
    return InitialState(tuple(states), periods, states.__getitem__)


def _ratio(model: RingDownModel, amplitude: float) -> float:
    """Frequency at this amplitude over the natural one."""
    return 1.0 if LINEAR_RESTORING in model.terms else frequency_ratio(min(abs(amplitude), LIMITS.angle_widest_rad))


def _natural_frequency(model: RingDownModel, cycles: HalfCycles) -> float:
    """w in rad/s: the median over the first six half cycles, or over all down to 0.3 rad if they are more."""
    each = np.pi / np.diff(cycles.passages_s) / [_ratio(model, a) for a in cycles.turning_rad]
    wide = np.count_nonzero(np.abs(cycles.turning_rad) > LIMITS.angle_wide_rad)
    return float(np.median(each[: max(LIMITS.angle_many_half_cycles, wide)]))


def _energy(model: RingDownModel, angle: Array) -> Array:
    """Energy of the turning points in units of I w^2."""
    linear = LINEAR_RESTORING in model.terms
    return np.asarray(0.5 * angle**2 if linear else 1.0 - np.cos(angle))


def _losses(model: RingDownModel, cycles: HalfCycles, w: float) -> tuple[float, ...]:
    """Values of all coefficients: losses by least squares with no negative one from the energies, others 0.

    The speed at which a friction falls is the one of some with which the losses explain the energies best.
    """
    typical = np.array([c.typical for c in model.coefficients])
    speeds = model.speeds_of_friction
    fastest = 2.0 * math.sin(0.5 * min(float(np.max(np.abs(cycles.turning_rad))), LIMITS.angle_widest_rad))
    best, left = _explained_losses(model, cycles, typical)
    for share in LIMITS.angle_speed_shares if speeds else ():
        scaled = typical.copy()
        scaled[list(speeds)] = share * fastest
        other, rest = _explained_losses(model, cycles, scaled)
        if rest < left:
            best, left = other, rest
    return tuple(float(x * w**q.power) for x, q in zip(best, model.coefficients, strict=True))


def _explained_losses(model: RingDownModel, cycles: HalfCycles, typical: Array) -> tuple[Array, float]:
    """(coefficients, rest of the energies) with the hidden ones at these typical values, all without dimension."""
    names = [c.name for c in model.coefficients]
    c = np.where([q.hidden for q in model.coefficients], typical, 0.0)
    lossy = [names.index(name) for name in model.losses]
    if not lossy:
        return c, 0.0
    energy = _energy(model, cycles.turning_rad)
    size = 0.5 * np.abs(cycles.turning_rad[1:] + 0.0) + 0.5 * np.abs(cycles.turning_rad[:-1])
    work = np.array([_work(model, min(a, LIMITS.angle_widest_rad), typical)[lossy] for a in size])
    scale = np.maximum(np.max(work, axis=0), 1e-300)
    from scipy.optimize import nnls  # here, because only angles need it

    sizes, rest = nnls(work / scale, energy[:-1] - energy[1:])
    # A friction of size 0 has no speed at which it falls.
    scaled = [t.coefficients[0].name for t in model.terms if any(q.hidden for q in t.coefficients)]
    least = [LIMITS.least_loss_share * sizes.max() * (names[k] in scaled) for k in lossy]
    c[lossy] = np.maximum(sizes, least) / scale
    return c, float(rest)


def _work(model: RingDownModel, amplitude: float, c: Array) -> Array:
    """Energy that a unit of each coefficient takes out of one half cycle of this amplitude, (coefficients,)."""
    x = math.pi * (np.arange(LIMITS.angle_work_points) + 0.5) / LIMITS.angle_work_points
    phi = -amplitude * np.cos(x)
    v = np.sqrt(np.maximum(2.0 * (_energy(model, np.array(amplitude)) - _energy(model, phi)), 0.0))
    grad = np.zeros(c.size + 1)
    total = np.zeros(c.size)
    for k in range(LIMITS.angle_work_points):
        acceleration(phi[k], v[k], 1.0, model.codes, model.widths, c, grad)
        total -= grad[:-1] * math.sin(x[k]) * amplitude * math.pi / LIMITS.angle_work_points
    return total


def _states(model: RingDownModel, cycles: HalfCycles, w: float, values: tuple[float, ...]) -> list[FitState]:
    """The states anchored at the turning point before t = 0 or soon after it, the nearer one first."""
    ratio = min(max(abs(cycles.turning_rad[0] / cycles.turning_rad[1]), 1.0), LIMITS.angle_most_decline)
    amplitude, time = float(cycles.turning_rad[0]), float(cycles.turning_s[0])
    anchors = [(time, amplitude)]
    while time > 0.0:
        time -= math.pi / (w * _ratio(model, amplitude))
        amplitude *= -ratio
        anchors.append((time, math.copysign(min(abs(amplitude), LIMITS.angle_widest_rad), amplitude)))
    near = [(t, a) for t, a in anchors if abs(w * t) < math.pi / _ratio(model, a)]
    observation = AngleObservation()
    return [
        FitState(
            MotionParameters(w=w, theta=-w * t, amplitude=a, values=values), observation, np.array([cycles.zero_rad])
        )
        for t, a in sorted(near, key=lambda anchor: abs(anchor[0]))
    ]

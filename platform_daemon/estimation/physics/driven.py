"""A rotor that a field drives in phase with its velocity: where the zeros of that field must lie.

The drive's torque is (m_r / I) (B_v cos(phi) - B_u sin(phi)) (paper, eq:Thread_ODE_norm with the field of the coils).
Half period after half period the model is integrated forward under the very field that will be played, until the
velocity turns; the field's next zero is put there.  In this way field and velocity change their signs together,
however much the frequency falls with the growing amplitude.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, IntArray
from platform_daemon.estimation.numerics.jit import kernel, part
from platform_daemon.estimation.thresholds import THRESHOLDS

from .models import RingDownModel
from .torques.dispatch import acceleration

LIMITS = THRESHOLDS.physics
STEPS = LIMITS.driven_steps
AT_MOST = LIMITS.driven_half_periods
ROUNDS = LIMITS.driven_rounds
SETTLED = LIMITS.driven_settled
STICKS = LIMITS.driven_sticks
MOVED = LIMITS.driven_moved
HIGHER = LIMITS.driven_tolerances
WEAKER = LIMITS.driven_weaker
SIDEWAYS = LIMITS.driven_least_share
_TURN_ROUNDS = LIMITS.driven_turn_rounds
_TURN_SPEED = LIMITS.driven_turn_speed
_TURN_TIME = LIMITS.driven_turn_time
_MOVING = LIMITS.driven_moving


class NoPlanError(ValueError):
    """The model does not swing under this field, or too far."""


@dataclass(frozen=True)
class PhasePlan:
    """zeros_s: (n + 1,) instants at which the field changes its sign, s from the start of TX, the first at or before
    it; first_sign: of the field between the first two; deflection_rad: (n,) |phi| at the end of every half period.
    """

    zeros_s: Array
    first_sign: int
    deflection_rad: Array


@dataclass(frozen=True)
class DrivenModel:
    """A model with values, and a field.

    w = 2 pi f_nat, rad/s; values: coefficients, in the model's order and units; push: (m_r / I) B along v and along u,
    rad/s^2, of the field's amplitude; rectangle_duty: share of a half period that a rectangle of the voltage fills,
    None: the field is a sine; lag_s: L/R of the loop, through which the field follows a rectangle.
    """

    model: RingDownModel
    w: float
    values: tuple[float, ...]
    push: tuple[float, float]
    rectangle_duty: float | None = None
    lag_s: float = 0.0

    def until_turn(
        self, state: tuple[float, float, float], since: float, half: float, sign: float
    ) -> tuple[float, float, float]:
        """(angle, dimensionless time, lagging field) at which the velocity turns next; time NaN: it does not.

        state: phi, phi'/w, and the field in units of its amplitude where it lags, at `since` after the zero of the
        field that lasts for `half` (negative: back in time, without a field); sign: of the field.
        """
        codes, widths, c = self._terms()
        push = self._push() if half > 0 else np.zeros(2)
        shape = self._shape(half, sign)
        phi, s, field = _until_turn(np.array(state), float(since), float(half), push, shape, codes, widths, c)
        return float(phi), float(s), float(field)

    def reached_rad(self, zeros_s: Array, first_sign: int) -> float:
        """Amplitude from rest at the last zero of a field that may have been planned for another model, rad."""
        shape = self._shape(math.pi, first_sign)
        phi, v, _ = _after(self.w * zeros_s, np.zeros(3), self._push(), shape, *self._terms())
        energy = 0.5 * v * v + 1.0 - math.cos(phi)
        return math.acos(1.0 - energy) if energy < 2.0 else math.pi

    def _terms(self) -> tuple[IntArray, IntArray, Array]:
        c = np.array([q / self.w**p for q, p in zip(self.values, self.model.powers, strict=True)])
        return self.model.codes, self.model.widths, c

    def _push(self) -> Array:
        return np.array([p / self.w**2 for p in self.push])

    def _shape(self, half: float, sign: float) -> Array:
        """Duty (negative: a sine), lag, by which share of a half period a rectangle begins earlier, sign."""
        duty = -1.0 if self.rectangle_duty is None else float(self.rectangle_duty)
        # The shortest lag that a step can follow; a shorter one is none.
        lag = max(self.w * self.lag_s, 2.0 * abs(half) / STEPS)
        return np.array([duty, lag, math.atan(math.pi * lag / half) / math.pi, float(sign)])


def plan_phase(driven: DrivenModel, tx_s: float, start: tuple[float, float] = (0.0, 0.0)) -> PhasePlan:
    """Where the field's zeros must lie for `tx_s` of TX, from angle (rad) and velocity (rad/s) at its start on.

    Raises:
        NoPlanError: the field pushes hardly along v, friction holds the rotor, or it would swing beyond what the
            model describes.
    """
    along_v, along_u = driven.push
    if not abs(along_v) > SIDEWAYS * math.hypot(along_v, along_u):
        raise NoPlanError("the field is hardly along v, and so pushes no rotor that is near its rest")
    phi, v, field = start[0], start[1] / driven.w, 0.0
    moving = 1 if v > 0 or (v == 0 and phi <= 0) else -1
    sign = moving * (1 if along_v > 0 else -1)
    at, half = _last_turn(driven, phi, v), math.pi
    zeros, deflections, first_sign = [at], [], sign
    while at < driven.w * tx_s:
        turned, half, field = _settled(driven, (phi, v, field), max(0.0, -at), half, sign)
        if not abs(turned) < min(driven.model.largest_angle_rad, 0.5 * math.pi):
            raise NoPlanError(f"the rotor would swing to 90 degrees after {(at + half) / driven.w:.3g} s of TX")
        at, phi, v, sign = at + half, turned, 0.0, -sign
        zeros.append(at)
        deflections.append(abs(turned))
    if max(deflections, default=0.0) < MOVED * STICKS:
        raise NoPlanError("the field hardly moves the rotor: friction holds it, or the field is too weak")
    return PhasePlan(np.array(zeros) / driven.w, first_sign, np.array(deflections))


def _settled(
    driven: DrivenModel, state: tuple[float, float, float], since: float, half: float, sign: float
) -> tuple[float, float, float]:
    """(angle at the next turn, length of this half period, field there), once field and motion are as long."""
    for _ in range(ROUNDS):
        turned, length, field = driven.until_turn(state, since, half, sign)
        if not math.isfinite(length):
            raise NoPlanError("the field does not move the rotor, or moves it beyond what the model describes")
        if abs(length - half) < SETTLED * half:
            break
        half = length
    return turned, length, field


def _last_turn(driven: DrivenModel, phi: float, v: float) -> float:
    """Dimensionless time, at most 0, of the turning point before a state; 0 at rest or at a turning point."""
    if v == 0:
        return 0.0
    _, s, _ = driven.until_turn((phi, v, 0.0), 0.0, -math.pi, 1.0)
    if not math.isfinite(s):
        raise NoPlanError("no oscillation passes through the state at the start of TX")
    return s


def plan_for_all(driven: DrivenModel, tx_s: float, tolerance: float) -> PhasePlan:
    """The plan from rest that swings the rotor furthest in the worst case of f_nat off by `tolerance` (relative).

    A field that falls in frequency catches a rotor that it meets from above and keeps it in step, one that begins too
    low loses it.  Tried are plans of models with a higher f_nat and a weaker push.  Raises NoPlanError as `plan_phase`.
    """
    plan = plan_phase(driven, tx_s)
    if not tolerance:
        return plan
    truths = [replace(driven, w=driven.w * (1 + side * tolerance)) for side in (-1.0, 0.0, 1.0)]
    best = min(truth.reached_rad(plan.zeros_s, plan.first_sign) for truth in truths)
    for higher, weaker in itertools.product(HIGHER, WEAKER):
        push = (weaker * driven.push[0], weaker * driven.push[1])
        other = plan_phase(replace(driven, w=driven.w * (1 + higher * tolerance), push=push), tx_s)
        worst = min(truth.reached_rad(other.zeros_s, other.first_sign) for truth in truths)
        if worst > best:
            plan, best = other, worst
    return plan


@kernel
def _until_turn(state, since, half, push, shape, codes, widths, c):  # type: ignore[no-untyped-def]
    """(angle, time since the zero of the field, lagging field) at the next turn of the velocity; time NaN: none.

    Runge-Kutta steps of order 4, the last one shortened by the rule of false position; see DrivenModel.until_turn.
    """
    h = half / STEPS
    grad = np.zeros(max(c.size, 1))
    s = since
    began = 0.0
    for _ in range(int(AT_MOST * STEPS)):
        after = _step(state, s, h, half, push, shape, codes, widths, c, grad)
        if began != 0.0 and after[1] * began <= 0.0:
            low, high, v_low, v_high, t = 0.0, h, state[1], after[1], h
            for _ in range(_TURN_ROUNDS):
                t = low - v_low * (high - low) / (v_high - v_low)
                after = _step(state, s, t, half, push, shape, codes, widths, c, grad)
                if abs(after[1]) < _TURN_SPEED or abs(high - low) < _TURN_TIME:
                    break
                if after[1] * v_low > 0.0:
                    low, v_low, v_high = t, after[1], 0.5 * v_high
                else:
                    high, v_high, v_low = t, after[1], 0.5 * v_low
            return after[0], s + t, after[2]
        if began == 0.0 and abs(after[1]) > _MOVING:
            began = after[1]
        state, s = after, s + h
        if not abs(state[0]) < math.pi:
            break
    return state[0], math.nan, state[2]


@part
def _wanted(place, shape):  # type: ignore[no-untyped-def]
    """Field, or voltage of a rectangle, at a place in the half period, 0 to 1; beyond: the rectangle that follows."""
    if shape[0] < 0.0:
        return shape[3] * math.sin(math.pi * place) if 0.0 < place < 1.0 else 0.0
    place += shape[2]
    if abs(place - 0.5) <= 0.5 * shape[0]:
        return shape[3]
    return -shape[3] if place >= 1.5 - 0.5 * shape[0] else 0.0


@part
def _step(state, s, h, half, push, shape, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """One step of length h from `state` at s."""
    k = np.zeros((4, 3))
    for n in range(4):
        share = 0.0 if n == 0 else (1.0 if n == 3 else 0.5)
        now = state if n == 0 else state + share * h * k[n - 1]
        wanted = _wanted((s + share * h) / half, shape)
        sigma = min(1.0, max(-1.0, now[1] / STICKS))
        torque, _, _ = acceleration(now[0], now[1], sigma, codes, widths, c, grad)
        field = wanted if shape[0] < 0.0 else now[2]
        k[n, 0] = now[1]
        k[n, 1] = torque + field * (push[0] * math.cos(now[0]) - push[1] * math.sin(now[0]))
        k[n, 2] = (wanted - now[2]) / shape[1] if shape[0] >= 0.0 else 0.0
    return state + h * (k[0] + 2.0 * (k[1] + k[2]) + k[3]) / 6.0


@kernel
def _after(zeros, state, push, shape, codes, widths, c):  # type: ignore[no-untyped-def]
    """State (3,) at the last of the dimensionless instants `zeros` of a field that was planned before."""
    grad = np.zeros(max(c.size, 1))
    for n in range(zeros.size - 1):
        half = zeros[n + 1] - zeros[n]
        shape[2] = math.atan(math.pi * shape[1] / half) / math.pi
        for k in range(STEPS):
            state = _step(state, k * half / STEPS, half / STEPS, half, push, shape, codes, widths, c, grad)
        shape[3] = -shape[3]
    return state

"""A kick, such as a touch of the table or a slammed door, changes the angular velocity at one instant.

From that instant on it is another swing, which `kicked_motion` follows.  That of a kick that is a little larger differs
by a solution of the linearised equation of motion that begins with a unit step of the velocity: a combination of its
derivatives by phase and by amplitude.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from platform_daemon.diagnosis.shots.linearisation import Linearisation
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .effect import Candidate, Detail, Effect

_LIMITS = THRESHOLDS.effects
KICK = Effect(
    id="kick",
    unit="rad/s",
    sign=0,
    separates=("more_shots",),
    signature="amplitude and phase change at one instant",
    source="a touch, a step nearby, a door",
)


def kick(time_s: float, period_s: float, rate_hz: float, trials: float) -> Candidate:
    """At one instant of a single recorded swing."""

    def near(share: float) -> list[Candidate]:
        moves_s = [share * step * period_s / _LIMITS.kick_parts for step in _LIMITS.kick_moves]
        return [kick(time_s + move_s, period_s, rate_hz, trials) for move_s in moves_s]

    detail = Detail(sample=round(time_s * rate_hz))
    return Candidate(
        KICK, detail, columns=partial(_response, time_s), size=1, near=near, trials=trials, kick_at_s=time_s
    )


def moved_kick(kick_: Candidate, by_s: float, linearisation: Linearisation) -> Candidate:
    """The same kick at another instant, but not so near the ends that it is told from neither start nor end."""
    assert kick_.kick_at_s is not None
    period_s = 2.0 * math.pi / linearisation.state.dynamics.w
    time, margin_s = linearisation.time_s, THRESHOLDS.selection.kick_margin_periods * period_s
    time_s = max(float(time[0]) + margin_s, min(kick_.kick_at_s + by_s, float(time[-1]) - margin_s))
    return kick(time_s, period_s, linearisation.prepared.shot.rate_hz, kick_.trials)


def answer_to_lateness(time_s: float, speed_rad_per_s: float, linearisation: Linearisation) -> Array:
    """Change of the angle, (1, m), per second by which a kick comes later.

    So much longer the swing goes on with the old velocity, and so much shorter with the new one.  The difference of
    the torques before and after is left out, which is small where the friction is.
    """
    return -speed_rad_per_s * linearisation.state.dynamics.w * _answer(time_s, linearisation, step_of_angle_shares)[0]


def _response(time_s: float, linearisation: Linearisation) -> Array:
    """Change of the angle by a kick of 1 rad/s, (1, 1, m)."""
    return _answer(time_s, linearisation, kick_shares)


def _answer(time_s: float, linearisation: Linearisation, shares: Callable[[Array, Array], Array]) -> Array:
    """Change of the angle by a solution of the linearised equation of motion that begins at an instant, over w."""
    time = linearisation.time_s
    angles, speeds = linearisation.free_motion[:, 0], linearisation.free_motion[:, 1]
    at = [np.array([[np.interp(time_s, time, row)] for row in rows]) for rows in (angles, speeds)]
    gain = linearisation.state.observation.gains(linearisation.state.dynamics.w)[0, 0] / linearisation.state.dynamics.w
    return np.asarray((gain * (time >= time_s) * (shares(*at)[:, 0] @ angles))[None, None])


def kick_shares(angles: Array, speeds: Array) -> Array:
    """Weights (2, n) of two solutions (2, n) in the one with angle 0 and velocity 1 at each instant."""
    return _over_wronskian(np.stack([-angles[1], angles[0]]), angles, speeds)


def step_of_angle_shares(angles: Array, speeds: Array) -> Array:
    """The same with angle 1 and velocity 0 at each instant."""
    return _over_wronskian(np.stack([speeds[1], -speeds[0]]), angles, speeds)


def _over_wronskian(shares: Array, angles: Array, speeds: Array) -> Array:
    wronskian = angles[0] * speeds[1] - angles[1] * speeds[0]
    alive = np.abs(wronskian) > 0.0  # a rotor that sticks does not respond
    return np.where(alive, shares / np.where(alive, wronskian, 1.0), 0.0)

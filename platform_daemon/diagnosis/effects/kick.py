"""A kick: somebody touches the table, a door slams, and the swing goes on with another velocity.

From that instant on the motion differs by a solution of the linearised equation of motion that begins with a unit step
of the velocity: a combination of its derivatives by phase and by amplitude.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from platform_daemon.estimation import Array

from ..shots.linearisation import Linearisation
from .effect import Candidate, Detail, Effect

KICK = Effect(
    "kick", "rad/s", 0, ("more_shots",), "amplitude and phase change at one instant",
    "a touch, a step nearby, a door",
)  # fmt: skip
_MOVES = (-3.0, -1.0, 0.0, 1.0, 3.0)  # of the instant, in 40ths of a period


def kick(time_s: float, period_s: float, rate_hz: float, trials: float) -> Candidate:
    """At one instant of a single recorded swing."""

    def near(share: float) -> list[Candidate]:
        return [kick(time_s + share * step * period_s / 40.0, period_s, rate_hz, trials) for step in _MOVES]

    detail = Detail(sample=round(time_s * rate_hz))
    return Candidate(KICK, detail, columns=partial(_answer, time_s), size=1, near=near, trials=trials)


def _answer(time_s: float, look: Linearisation) -> Array:
    """Change of the angle by a kick of 1 rad/s, (1, 1, m)."""
    time = look.time_s
    angles, speeds = look.free_motion[:, 0], look.free_motion[:, 1]
    at = [np.array([[np.interp(time_s, time, row)] for row in rows]) for rows in (angles, speeds)]
    gain = look.state.observation.gains(look.state.dynamics.w)[0, 0] / look.state.dynamics.w
    return np.asarray((gain * (time >= time_s) * (begun(*at)[:, 0] @ angles))[None, None])


def begun(angles: Array, speeds: Array) -> Array:
    """Shares (2, n) of two solutions (2, n) in the one that begins at each instant with angle 0 and velocity 1."""
    wronskian = angles[0] * speeds[1] - angles[1] * speeds[0]
    alive = np.abs(wronskian) > 0.0  # a rotor that sticks answers to nothing
    return np.where(alive, np.stack([-angles[1], angles[0]]) / np.where(alive, wronskian, 1.0), 0.0)

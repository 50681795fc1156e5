"""Where a kick would explain most of what is left of a single recorded swing: at every instant, by sums over what comes
after it."""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation import Array

from ..effects.effect import Candidate
from ..effects.kick import begun, kick
from ..regression.joint_fit import JointFit

_OFFERED = 2  # instants
_MARGIN = 1.5  # periods at either end: there it is a matter of start or end
_APART = 3.0  # periods
_SEEN = 1e-6  # share of the answer to a kick that no parameter takes up


def kicks(at: JointFit) -> list[Candidate]:
    """Where they gain most, the most surprising first; none of several shots, or of what is no angle."""
    look = at.linear[0].seen
    if len(at.started) != 1 or look.free_motion.size == 0:
        return []
    time, period = look.time_s, 2.0 * math.pi / at.states[0].dynamics.w
    inside = (time > time[0] + _MARGIN * period) & (time < time[-1] - _MARGIN * period)
    gain = np.where(inside, _gains(at), 0.0)
    found: list[Candidate] = []
    while len(found) < _OFFERED and gain.max() > 0.0:
        place = int(np.argmax(gain))
        found.append(kick(float(time[place]), period, look.started.shot.rate_hz, float(time.size)))
        gain[np.abs(time - time[place]) < _APART * period] = 0.0
    return found


def _gains(at: JointFit) -> Array:
    """Fall of chi^2 by a kick at every instant, (m,)."""
    linear, look = at.linear[0], at.linear[0].seen
    shares, scaled = begun(look.free_motion[:, 0], look.free_motion[:, 1]), _scaled(look.free_motion[:, 0], at)
    inside = np.concatenate([linear.own, linear.q], axis=1)
    if linear.columns.shape[1]:
        inside = np.concatenate([inside, np.linalg.qr(linear.beside(linear.columns))[0]], axis=1)
    residual = linear.residual - inside @ (inside.T @ linear.residual)
    along = np.sum(shares * _later(scaled * residual), axis=0)
    squares = _later(np.stack([scaled[0] ** 2, 2.0 * scaled[0] * scaled[1], scaled[1] ** 2]))
    power = shares[0] ** 2 * squares[0] + shares[0] * shares[1] * squares[1] + shares[1] ** 2 * squares[2]
    left = power.copy()
    for column in inside.T:
        left -= np.sum(shares * _later(scaled * column), axis=0) ** 2
    seen = left > _SEEN * power
    return np.where(seen, along**2 / np.where(seen, left, 1.0), 0.0)


def _scaled(angles: Array, at: JointFit) -> Array:
    """In units of the noise, as if that were white."""
    return np.asarray(angles * at.started[0].white.scale[0])


def _later(rows: Array) -> Array:
    """Sums over each instant and all after it, (..., m)."""
    return np.asarray(np.cumsum(rows[..., ::-1], axis=-1)[..., ::-1])

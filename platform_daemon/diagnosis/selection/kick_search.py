"""Score of a kick at every instant of a single recorded swing, from cumulative sums over all later instants.

What a law of friction is wrong by can look like a kick in the whole record. The few periods around the instant tell
them apart: there everything slow is a sum of harmonics of slowly changing size, and a step of the velocity is not.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.kick import KICK, kick, kick_shares
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .local_swing import waves

_LIMITS = THRESHOLDS.selection


def kicks(at: JointFit) -> list[Candidate]:
    """Where they gain most, the most surprising first; none of several shots, or of what is no angle."""
    linearisation = at.linear[0].linearisation
    if len(at.prepared) != 1 or linearisation.free_motion.size == 0:
        return []
    time, period = linearisation.time_s, 2.0 * math.pi / at.states[0].dynamics.w
    inside = (time > time[0] + _LIMITS.kick_margin_periods * period) & (
        time < time[-1] - _LIMITS.kick_margin_periods * period
    )
    for c in at.hypothesis.effects:
        inside &= c.kick_at_s is None or np.abs(time - c.kick_at_s) > _LIMITS.kick_margin_periods * period
    gain = np.where(inside, _gains(at), 0.0)
    found: list[Candidate] = []
    while len(found) < _LIMITS.offered_kicks and gain.max() > 0.0:
        place = int(np.argmax(gain))
        found.append(kick(float(time[place]), period, linearisation.prepared.shot.rate_hz, float(time.size)))
        gain[np.abs(time - time[place]) < _LIMITS.kick_spacing_periods * period] = 0.0
    return found


def kick_missing(at: JointFit) -> bool:
    """True if the swing around the instant of a fitted kick surely shows less than a part of it.

    A kick that is too small to be seen in so few periods is not missing, unless it stands beside torques: then it may
    as well mend what these are wrong by.
    """
    pairs = zip(at.hypothesis.common, at.hypothesis.slices, strict=True)
    alone = not at.hypothesis.torques
    return any(_missing(at, c.detail.sample or 0, where, alone) for c, where in pairs if c.effect is KICK)


def _missing(at: JointFit, sample: int, where: slice, alone: bool) -> bool:
    """Of the kick at a sample, whose strength is at this place; alone: beside no torques."""
    strength = float(at.strengths[where][0])
    near = _shown(at, sample, where, _LIMITS.kick_margin_periods)
    if near is None:
        return not alone
    if _surely_less(*near, strength):
        return True
    if alone or near[0] > _LIMITS.kick_shown_sigma * near[1]:
        return False
    # In more periods what a law is wrong by changes hardly faster, and a smaller kick stands out.
    wide = _shown(at, sample, where, _LIMITS.kick_wide_periods, degrees=_LIMITS.kick_wide_degrees, harmonics=(1,))
    return wide is None or wide[0] < _LIMITS.kick_sigma * wide[1] or wide[0] < _LIMITS.kick_local_share * abs(strength)


def _surely_less(shown: float, sd: float, strength: float) -> bool:
    return shown + _LIMITS.kick_sigma * sd < _LIMITS.kick_local_share * abs(strength)


def _shown(at: JointFit, sample: int, where: slice, periods: float, **slow_waves: Any) -> tuple[float, float] | None:
    """The size of a fitted kick, positive if it has the sign of its strength, and its standard deviation, as so many
    periods on either side of its instant show it beside slow waves; None where there are too few instants."""
    linear, record = at.linear[0], at.prepared[0].shot.record
    frequency_hz = at.states[0].dynamics.w / (2.0 * math.pi)
    time = linear.linearisation.time_s - sample * record.dt_s
    near = np.abs(time) < periods / frequency_hz
    slow = waves(time[near], frequency_hz, periods / frequency_hz, **slow_waves)[0].T
    if slow.shape[0] < slow.shape[1] + _LIMITS.kick_free_instants:
        return None
    q = np.linalg.qr(slow)[0]
    strength, column = float(at.strengths[where][0]), linear.columns[near, where][:, 0]
    column, left = column - q @ (q.T @ column), linear.residual[near] - q @ (q.T @ linear.residual[near])
    power = float(column @ column)
    more = float(column @ left) / max(power, 1e-300)
    rest = left - more * column
    sd = math.sqrt(max(1.0, float(rest @ rest) / (rest.size - q.shape[1] - 1)) / max(power, 1e-300))
    return math.copysign(1.0, strength) * (strength + more), sd


def _gains(at: JointFit) -> Array:
    """Fall of chi^2 by a kick at every instant, (m,)."""
    linear, linearisation = at.linear[0], at.linear[0].linearisation
    shares, scaled = (
        kick_shares(linearisation.free_motion[:, 0], linearisation.free_motion[:, 1]),
        _scaled(linearisation.free_motion[:, 0], at),
    )
    inside = np.concatenate([linear.own, linear.q], axis=1)
    if linear.columns.shape[1]:
        inside = np.concatenate([inside, np.linalg.qr(linear.without_own(linear.columns))[0]], axis=1)
    residual = linear.residual - inside @ (inside.T @ linear.residual)
    along = np.sum(shares * _later(scaled * residual), axis=0)
    squares = _later(np.stack([scaled[0] ** 2, 2.0 * scaled[0] * scaled[1], scaled[1] ** 2]))
    power = shares[0] ** 2 * squares[0] + shares[0] * shares[1] * squares[1] + shares[1] ** 2 * squares[2]
    left = power.copy()
    for column in inside.T:
        left -= np.sum(shares * _later(scaled * column), axis=0) ** 2
    visible = left > _LIMITS.kick_seen_share * power
    return np.where(visible, along**2 / np.where(visible, left, 1.0), 0.0)


def _scaled(angles: Array, at: JointFit) -> Array:
    """In units of the noise, as if that were white."""
    return np.asarray(angles * at.prepared[0].white.scale[0])


def _later(rows: Array) -> Array:
    """Sums over each instant and all after it, (..., m)."""
    return np.asarray(np.cumsum(rows[..., ::-1], axis=-1)[..., ::-1])

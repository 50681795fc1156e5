"""Refits during the search: of another hypothesis, and with hidden scales and places optimised."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.kick import answer_to_lateness, moved_kick
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly, noise_factor, starting_point
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .sign_constraints import without_gain_of_energy

_LIMITS = THRESHOLDS.selection


def refit(hypothesis: Hypothesis, at: JointFit, pool: Executor) -> JointFit | None:
    """The joint fit of a hypothesis, started from another one; None if the trajectory is lost."""
    try:
        # What is new begins at 0, so that the shots' own parameters can follow it.
        return fit_jointly(at.prepared, hypothesis, pool, *starting_point(at, hypothesis))
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def allowed_refit(hypothesis: Hypothesis, at: JointFit, pool: Executor) -> JointFit | None:
    """A refit without losses that would feed energy into the motion: these are held at 0."""
    found = refit(hypothesis, at, pool)
    try:
        return None if found is None else without_gain_of_energy(found, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def refined(at: JointFit, pool: Executor) -> JointFit:
    """The joint fit with the hidden scales and places of its common effects where chi^2 is least."""
    for share in _LIMITS.refined_shares:
        for _ in range(_LIMITS.most_place_moves):
            before = at
            for c in at.hypothesis.common:
                at = _kick_in_time(at, c, pool) if c.kick_at_s is not None else at
                at = _refined_effect(at, c, share, pool) if c.near is not None and c in at.hypothesis.common else at
            if before.chi2 - at.chi2 < _LIMITS.place_move_chi2 * at.noise_factor:
                break
    return at


def _refined_effect(at: JointFit, c: Candidate, share: float, pool: Executor) -> JointFit:
    """One effect at the best of its neighbouring places; the refit itself if none is better."""
    reduced = refit(at.hypothesis.without(c), at, pool)
    if reduced is None or c.near is None:
        return at
    table = score_table(reduced, [replace(v, parts=()) for v in c.near(share)], pool)
    scores = [(score.gain, b.candidate) for b in table.blocks if (score := table.gain([b])) is not None]
    if not scores:
        return at
    best = max(scores, key=lambda pair: pair[0])[1]
    trial = allowed_refit(reduced.hypothesis.plus(best), reduced, pool)
    return at if trial is None or trial.chi2 >= at.chi2 else trial


def _kick_in_time(at: JointFit, c: Candidate, pool: Executor) -> JointFit:
    """A kick at the instant where chi^2 is least, by steps of Newton from where it is."""
    for _ in range(_LIMITS.most_place_moves):
        late_s, sd_s, _ = lateness(at, c)
        if not math.isfinite(sd_s):
            break
        most_s = _LIMITS.kick_move_periods * 2.0 * math.pi / at.states[0].dynamics.w
        moved = moved_kick(c, max(-most_s, min(late_s, most_s)), at.linear[0].linearisation)
        hypothesis = replace(at.hypothesis, effects=tuple(moved if o is c else o for o in at.hypothesis.effects))
        try:
            found = fit_jointly(at.prepared, hypothesis, pool, at.states, at.strengths)
        except (LostTrajectoryError, np.linalg.LinAlgError):
            break
        if found.chi2 >= at.chi2:
            break
        settled = at.chi2 - found.chi2 < _LIMITS.place_move_chi2 * at.noise_factor
        at, c = found, moved
        if settled:
            break
    return at


def lateness(at: JointFit, c: Candidate) -> tuple[float, float, float]:
    """By how much a kick comes later than fitted, s, its standard deviation, and the fall of the strength per second.

    To first order; the standard deviation is infinite where nothing tells.
    """
    assert c.kick_at_s is not None
    linear, where = at.linear[0], dict(zip(map(id, at.hypothesis.common), at.hypothesis.slices, strict=True))[id(c)]
    answer = answer_to_lateness(c.kick_at_s, float(at.strengths[where][0]), linear.linearisation)
    column = linear.without_own(linear.linearisation.white(answer[None]).T)[:, 0]
    columns = linear.without_own(linear.columns)
    along = np.linalg.lstsq(columns, column, rcond=None)[0]
    column = column - columns @ along
    power = float(column @ column)
    if not power > 0.0:
        return 0.0, math.inf, 0.0
    sd_s = math.sqrt(at.noise_factor / power)
    return float(column @ linear.residual) / power, sd_s, float(along[where][0])


def refined_own(
    at: JointFit, c: Candidate, pool: Executor, shares: Sequence[float] = _LIMITS.own_refined_shares
) -> Candidate:
    """An effect that every shot has for itself, where it gains most; shares: of a grid step, in turn."""
    bin_hz = 1.0 / float(at.prepared[0].time_s[-1])
    for share in shares:
        if c.near is not None:
            scale = share * bin_hz if c.detail.tau_s is None else share
            c = max(c.near(scale), key=lambda v: own_gain(at, v, pool).fall)
    return c


def lines_in_place(at: JointFit, pool: Executor) -> JointFit:
    """The joint fit with every oscillation where it gains most beside what was found after it; itself if none moves."""
    for _ in range(_LIMITS.most_place_moves):
        before = at
        for c in at.hypothesis.own:
            reduced = refit(at.hypothesis.without(c), at, pool) if c.near is not None else None
            moved = c if reduced is None else refined_own(reduced, c, pool, _LIMITS.line_place_shares)
            if reduced is not None and moved.key != c.key:
                trial = allowed_refit(reduced.hypothesis.plus(moved), at, pool)
                at = at if trial is None or trial.chi2 >= at.chi2 else trial
        if before.chi2 - at.chi2 < _LIMITS.place_move_chi2 * at.noise_factor:
            break
    return at


@dataclass(frozen=True)
class OwnGain:
    """What an additive effect of every shot's own gains.

    Attributes:
        fall: of chi^2. noise_factor: of what it leaves over, by which the fall is to be divided.
        columns: of all shots together.
    """

    fall: float
    noise_factor: float
    columns: int

    @property
    def gain(self) -> float:
        """Fall of chi^2 over the noise factor."""
        return self.fall / self.noise_factor


def own_gain(at: JointFit, candidate: Candidate, pool: Executor) -> OwnGain:
    """Gain judged by the noise of the residual after the effect, of which it may be the largest part before."""

    def one(k: int) -> tuple[float, float, Callable[[], float], int]:
        linear = at.linear[k]
        assert candidate.columns is not None
        columns = linear.linearisation.white(candidate.columns(linear.linearisation)).T
        q, _ = np.linalg.qr(linear.without_own(columns))
        residual = linear.without_own(linear.residual)
        along = q.T @ residual
        left = residual - q @ along
        return float(along @ along), float(left @ left), lambda: linear.samples_per_value_of(left), columns.shape[1]

    parts = list(pool.map(one, range(len(at.linear))))
    factor = noise_factor(sum(p[1] for p in parts) / at.dof, [(p[1], p[2]) for p in parts])
    return OwnGain(sum(p[0] for p in parts), factor, sum(p[3] for p in parts))


def own_values(at: JointFit, effect: Candidate) -> list[tuple[Array, Array]]:
    """Of an accepted effect of every shot's own: values (k,) and their covariance (k, k), of each shot.

    Beside the other such effects; the motion's parameters and the common effects stay as they were fitted.
    """
    found = []
    for linear in at.linear:
        assert effect.columns is not None
        here = linear.linearisation
        shared = at.hypothesis.additive_part(at.strengths, at.hypothesis.shared_columns(here))
        columns = here.white(effect.columns(here)).T
        others = [here.white(o.columns(here)).T for o in at.hypothesis.own if o is not effect and o.columns]
        wide, size = np.concatenate([columns, *others], axis=1), columns.shape[1]
        values = np.linalg.lstsq(wide, here.whitened - shared, rcond=None)[0][:size]
        found.append((values, at.noise_factor * np.linalg.pinv(wide.T @ wide)[:size, :size]))
    return found

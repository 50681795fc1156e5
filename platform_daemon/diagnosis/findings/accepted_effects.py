"""Accepted effects with their evidence: strength, chance, what they gain on held-out data, what they look like."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation import is_mains

from ..effects.additive import LINE, MAINS, MAINS_TOLERANCE
from ..effects.clock import gap
from ..effects.effect import Candidate
from ..regression.cross_validation import CrossValidation
from ..regression.joint_fit import JointFit
from ..regression.score_test import ScoreTable, score_table
from ..selection.confounders import Confounder, confounders, gain_of, two_in_place
from ..selection.data_integrity import DataDefect
from ..selection.scales import strength_spread
from ..selection.significance import log_chance
from ..selection.stepwise import Selection
from ..validation.validated_effects import ReplacedEffects, held_out_gain_of, without

_NEAR = 4.0  # rise of chi^2 up to which another hidden scale tells of the strength's error
_SCALES = (0.1, 0.4, 1.5, 4.0)  # shares of a grid step at which a hidden scale is varied


@dataclass(frozen=True)
class AcceptedEffect:
    """An accepted effect.

    strength, std: in the effect's unit. held_out_gain: fall of the held-out chi^2 that it brings as the last one.
    """

    candidate: Candidate
    strength: float
    std: float
    log_p: float
    held_out_gain: float
    confounders: tuple[Confounder, ...]

    @property
    def rise(self) -> float:
        """Of chi^2 for the look-alike that is told apart least."""
        return min((r.rise for r in self.confounders), default=0.0)


def accepted_effects(
    found: Selection, seen: ScoreTable, after: CrossValidation, passed: ReplacedEffects, pool: Executor
) -> tuple[AcceptedEffect, ...]:
    """Accepted effects with their evidence."""
    named, final = [], seen.joint_fit
    angle = final.started[0].shot.record.quantity == "angle"  # there all sets of torques were fitted
    f_nat = float(np.mean([s.dynamics.w for s in final.states])) / (2.0 * math.pi)
    for c in final.hypothesis.effects:
        alike: tuple[Confounder, ...] = ()
        if c in final.hypothesis.common:
            where = next(s for o, s in zip(final.hypothesis.common, final.hypothesis.slices, strict=True) if o is c)
            value, std = _strength(c, final, where)
            std = max(std, _scale_spread(c, final, found.base, pool)) if c.hidden else std
            value, std = c.public(value, std, f_nat)
            log_p = log_chance(gain_of(final, c), c.size, found.trials * c.trials)
            rivals = confounders(seen, c, pool)
            alike = tuple(r for r in rivals if r.indistinguishable)
            alike += () if angle else tuple(two_in_place(seen, c, rivals, pool))
            alike += tuple(r for r in passed.get(c.key, ()) if r.indistinguishable)
        else:
            value, std, log_p = _own_strength(c, final, found.trials)
            alike = _named_alike(c)
        named.append(AcceptedEffect(c, value, std, log_p, held_out_gain_of(final, c, after, found.base, pool), alike))
    return tuple(named)


def passed_over(at: JointFit, trials: float) -> tuple[AcceptedEffect, ...]:
    """The common effects of a set that was not accepted, as they were fitted; nothing is held out for them."""
    f_nat, found = float(np.mean([s.dynamics.w for s in at.states])) / (2.0 * math.pi), []
    for c, where in zip(at.hypothesis.common, at.hypothesis.slices, strict=True):
        value, std = c.public(*_strength(c, at, where), f_nat)
        log_p = log_chance(gain_of(at, c), c.size, trials * c.trials)
        found.append(AcceptedEffect(c, value, std, log_p, math.nan, ()))
    return tuple(found)


def _named_alike(c: Candidate) -> tuple[Confounder, ...]:
    """A single line at a multiple of the mains may be either."""
    frequency = c.detail.frequency_hz or 0.0
    if c.effect is LINE and is_mains(frequency, relative=MAINS_TOLERANCE):
        return (Confounder(replace(c, effect=MAINS), 0.0, 0.0),)
    return (Confounder(replace(c, effect=LINE), 0.0, 0.0),) if c.effect is MAINS and len(c.tones_hz) == 1 else ()


def _strength(c: Candidate, final: JointFit, where: slice) -> tuple[float, float]:
    """One number for the strength: the strength itself, or the amplitude of an additive effect."""
    values, covariance = final.strengths[where], final.covariance[where, where] * final.noise_factor
    if c.size == 1:
        return float(values[0]), float(np.sqrt(covariance[0, 0]))
    return _amplitude(values, covariance, pairs=c.detail.frequency_hz is not None)


def _scale_spread(c: Candidate, final: JointFit, base: JointFit, pool: Executor) -> float:
    """By how much the strength moves with its hidden scale, per standard deviation of the latter."""
    if c.scale_limits is not None:
        return strength_spread(final, c, pool)
    beside = without(final, c, base, pool)
    assert c.near is not None
    seen = score_table(beside, [replace(v, parts=()) for share in _SCALES for v in c.near(share)], pool)
    scores = [score for b in seen.blocks if (score := seen.gain([b])) is not None]
    best = max(scores, key=lambda s: s.gain)
    near = [s for s in scores if best.gain - s.gain < _NEAR]
    return max(abs(float(s.strengths[0] - best.strengths[0])) / math.sqrt(max(best.gain - s.gain, 1.0)) for s in near)


def _amplitude(values: np.ndarray, covariance: np.ndarray, *, pairs: bool) -> tuple[float, float]:
    """Of the strongest channel: hypot of its cosine and sine, or the offset of largest size."""
    groups = values.reshape(-1, 2) if pairs else values.reshape(-1, 1)
    strongest = int(np.argmax(np.linalg.norm(groups, axis=1)))
    width = groups.shape[1]
    part = slice(strongest * width, (strongest + 1) * width)
    size = float(np.linalg.norm(values[part]))
    direction = values[part] / max(size, 1e-300)
    std = float(np.sqrt(direction @ covariance[part, part] @ direction))
    return (size, std) if pairs else (float(values[part][0]), std)


def _own_strength(c: Candidate, final: JointFit, trials: float) -> tuple[float, float, float]:
    """Rms amplitude over the shots of the strongest channel, its standard deviation, log chance."""
    rows, gain, directions = [], 0.0, 0
    for started, linear in zip(final.started, final.linear, strict=True):
        assert c.columns is not None
        columns = started.white(c.columns(linear.seen)).T
        others = [o for o in final.hypothesis.own if o is not c]
        wide = np.concatenate(
            [columns, *(started.white(o.columns(linear.seen)).T for o in others if o.columns)], axis=1
        )
        target = linear.seen.whitened
        values = np.linalg.lstsq(wide, target, rcond=None)[0][: columns.shape[1]]
        covariance = np.linalg.inv(columns.T @ columns) * final.noise_factor
        rows.append(_amplitude(values, covariance, pairs=True))
        gain += float(values @ (columns.T @ columns) @ values)
        directions += columns.shape[1]
    sizes = np.array(rows)
    value = float(np.sqrt(np.mean(sizes[:, 0] ** 2)))
    std = float(np.sqrt(np.mean(sizes[:, 1] ** 2) / len(rows)))
    return value, std, log_chance(gain / final.noise_factor, directions, trials * c.trials)


def gap_effects(gaps: Sequence[DataDefect]) -> list[AcceptedEffect]:
    """Clock gaps, one effect for each place, as mean over the shots that show it."""
    found = []
    for at in dict.fromkeys(f.at for f in gaps):
        same = [f for f in gaps if f.at == at]
        value = float(np.mean([f.value or 0.0 for f in same]))
        std = float(np.sqrt(np.sum([(f.sd or 0.0) ** 2 for f in same]))) / len(same)
        found.append(AcceptedEffect(gap(at or 0), value, std, min(f.log_p for f in same), 0.0, ()))
    return found

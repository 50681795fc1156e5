"""Accepted effects with their evidence: strength, p-value, gain on held-out data, look-alikes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.additive import LINE, MAINS
from platform_daemon.diagnosis.effects.effect import Candidate, Detail, Effect
from platform_daemon.diagnosis.regression.cross_validation import CrossValidation
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.score_test import ScoreTable, score_table
from platform_daemon.diagnosis.selection.confounders import Confounder, confounders, gain_of, two_in_place
from platform_daemon.diagnosis.selection.data_integrity import DataDefect
from platform_daemon.diagnosis.selection.refits import lateness, own_values
from platform_daemon.diagnosis.selection.scales import scale_errors, spread_by_other_scales
from platform_daemon.diagnosis.selection.significance import log_chance
from platform_daemon.diagnosis.selection.stepwise import Selection
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.diagnosis.validation.validated_effects import (
    ReplacedEffects,
    held_out_gain_of,
    log_chance_of,
    without,
)
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.screening.spectral_lines import is_mains

_LIMITS = THRESHOLDS.findings
GAP = Effect(
    id="clock_gap",
    unit="samples",
    sign=0,
    separates=(),
    signature="the phase steps at one sample",
    source="samples that the card or its link has lost, or stored twice: then negative",
)


@dataclass(frozen=True, kw_only=True)
class AcceptedEffect:
    """An accepted effect.

    strength, std: in the effect's unit. held_out_gain: fall of the held-out chi^2 that it brings as the last one.
    covariance: of the strength and of what fits hold beside it: names of the rows, (names, names). log_scale_std: of
    the logarithm of its first hidden scale or its time constant, to first order; None: it has none, or none was asked.
    """

    candidate: Candidate
    strength: float
    std: float
    log_p: float
    held_out_gain: float
    confounders: tuple[Confounder, ...]
    covariance: tuple[tuple[str, ...], Array] | None = None
    log_scale_std: float | None = None

    @property
    def rise(self) -> float:
        """Least rise of chi^2 over the look-alikes."""
        return min((r.rise for r in self.confounders), default=0.0)


def accepted_effects(
    found: Selection, table: ScoreTable, after: CrossValidation, replaced: ReplacedEffects, pool: Executor
) -> tuple[AcceptedEffect, ...]:
    """Accepted effects with their evidence."""
    named, final = [], table.joint_fit
    angle = final.prepared[0].shot.record.quantity == "angle"  # there all sets of torques were fitted
    f_nat = float(np.mean([s.dynamics.w for s in final.states])) / (2.0 * math.pi)
    others = spread_by_other_scales(final, pool)
    for c in final.hypothesis.effects:
        alike: tuple[Confounder, ...] = ()
        log_scale_std: float | None = None
        if c in final.hypothesis.common:
            where = next(s for o, s in zip(final.hypothesis.common, final.hypothesis.slices, strict=True) if o is c)
            value, std = _strength(c, final, where)
            std = math.hypot(std, *others[where])
            if c.hidden or c.kick_at_s is not None:
                spread, log_scale_std = _scale_errors(c, final, found.base, pool)
                std = math.hypot(std, spread)
            value, std = c.public(value, std, f_nat)
            log_p = log_chance_of(final, c, found, pool)
            rivals = confounders(table, c, pool)
            alike = tuple(r for r in rivals if r.indistinguishable)
            alike += () if angle else tuple(two_in_place(table, c, rivals, pool))
            alike += tuple(r for r in replaced.get(c.key, ()) if r.indistinguishable)
            alike += _not_excluded(found, c)
        else:
            value, std = _own_strength(c, final)
            log_p = log_chance_of(final, c, found, pool)
            alike = _named_alike(c)
        named.append(
            AcceptedEffect(
                candidate=c,
                strength=value,
                std=std,
                log_p=log_p,
                held_out_gain=held_out_gain_of(final, c, after, found.base, pool),
                confounders=alike,
                log_scale_std=log_scale_std,
            )
        )
    return tuple(named)


def _not_excluded(found: Selection, effect: Candidate) -> tuple[Confounder, ...]:
    """What takes an effect's place in other sets of torques, where the named ones leave more than noise.

    A rise of chi^2 counts for no more than what excludes nothing: the errors are the model's.
    """
    if found.torques is None or effect.effect not in _effects_of(found.torques):
        return ()
    alike: list[Confounder] = []
    limit = THRESHOLDS.selection.told_apart_chi2
    for other in found.others:
        if effect.effect in _effects_of(other):
            continue
        rise = min((other.chi2 - found.torques.chi2) / found.torques.noise_factor, limit)
        new = [c for c in other.hypothesis.effects if c.effect not in _effects_of(found.torques) and _alike(c, effect)]
        alike += [Confounder(candidate=c, rise=rise, gain=gain_of(other, c), joint_fit=other) for c in new]
    return tuple(alike)


def _alike(one: Candidate, other: Candidate) -> bool:
    """Both act on the motion, and either both take energy or none does."""
    if one.term is None or other.term is None:
        return False
    return one.term.loses_energy == other.term.loses_energy


def _effects_of(at: JointFit) -> set[Effect]:
    return {c.effect for c in at.hypothesis.effects}


def rejected_effects(at: JointFit, trials: float) -> tuple[AcceptedEffect, ...]:
    """The common effects of a set that was not accepted, as they were fitted; nothing is held out for them."""
    f_nat, found = float(np.mean([s.dynamics.w for s in at.states])) / (2.0 * math.pi), []
    for c, where in zip(at.hypothesis.common, at.hypothesis.slices, strict=True):
        value, std = c.public(*_strength(c, at, where), f_nat)
        log_p = log_chance(gain_of(at, c), c.size, trials * c.trials)
        found.append(
            AcceptedEffect(candidate=c, strength=value, std=std, log_p=log_p, held_out_gain=math.nan, confounders=())
        )
    return tuple(found)


def _named_alike(c: Candidate) -> tuple[Confounder, ...]:
    """A single line at a multiple of the mains may be either."""
    frequency = c.detail.frequency_hz or 0.0
    if c.effect is LINE and is_mains(frequency, relative=THRESHOLDS.effects.mains_share):
        return (Confounder(candidate=replace(c, effect=MAINS), rise=0.0, gain=0.0),)
    return (
        (Confounder(candidate=replace(c, effect=LINE), rise=0.0, gain=0.0),)
        if c.effect is MAINS and len(c.tones_hz) == 1
        else ()
    )


def _strength(c: Candidate, final: JointFit, where: slice) -> tuple[float, float]:
    """One number for the strength: the strength itself, or the amplitude of an additive effect."""
    values, covariance = final.strengths[where], final.covariance[where, where] * final.noise_factor
    if c.size == 1:
        return float(values[0]), float(np.sqrt(covariance[0, 0]))
    return _amplitude(values, covariance, pairs=c.detail.frequency_hz is not None)


def _scale_errors(c: Candidate, final: JointFit, base: JointFit, pool: Executor) -> tuple[float, float | None]:
    """(by how much the strength moves with its hidden scale, or that of a kick with its instant, per standard deviation
    of the latter, that of the scale's logarithm; None for one of a grid)."""
    if c.kick_at_s is not None:
        _, sd_s, per_s = lateness(final, c)
        return abs(per_s) * sd_s if math.isfinite(sd_s) else 0.0, None
    if c.scale_limits is not None:
        spread, log_std = scale_errors(final, c, pool)
        return spread, log_std or None  # 0 where the data do not determine it
    reduced = without(final, c, base, pool)
    assert c.near is not None
    table = score_table(reduced, [replace(v, parts=()) for share in _LIMITS.scale_shares for v in c.near(share)], pool)
    scores = [score for b in table.blocks if (score := table.gain([b])) is not None]
    best = max(scores, key=lambda s: s.gain)
    near = [s for s in scores if best.gain - s.gain < _LIMITS.scale_chi2]
    off = (abs(float(s.strengths[0] - best.strengths[0])) / math.sqrt(max(best.gain - s.gain, 1.0)) for s in near)
    return max(off), None


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


def _own_strength(c: Candidate, final: JointFit) -> tuple[float, float]:
    """Rms amplitude over the shots of the strongest channel, and its standard deviation."""
    sizes = np.array([_amplitude(values, spread, pairs=True) for values, spread in own_values(final, c)])
    return float(np.sqrt(np.mean(sizes[:, 0] ** 2))), float(np.sqrt(np.mean(sizes[:, 1] ** 2) / len(sizes)))


def gap_effects(gaps: Sequence[DataDefect]) -> list[AcceptedEffect]:
    """Clock gaps, one effect for each place, as mean over the shots that show it."""
    found = []
    for at in dict.fromkeys(f.at for f in gaps):
        same = [f for f in gaps if f.at == at]
        value = float(np.mean([f.value or 0.0 for f in same]))
        std = float(np.sqrt(np.sum([(f.sd or 0.0) ** 2 for f in same]))) / len(same)
        found.append(
            AcceptedEffect(
                candidate=Candidate(GAP, Detail(sample=at or 0)),
                strength=value,
                std=std,
                log_p=min(f.log_p for f in same),
                held_out_gain=0.0,
                confounders=(),
            )
        )
    return found


def not_accepted(
    found: Selection, final: JointFit, named: tuple[AcceptedEffect, ...], doubts: tuple[str, ...]
) -> tuple[tuple[AcceptedEffect, ...], str]:
    """Effects that gain although nothing is explained, and why they were not accepted."""
    if found.rejected is not None and found.rejected.chi2 < final.chi2:
        return rejected_effects(found.rejected, found.trials), "it fits better, but does not predict what was not used"
    return named, doubts[0] if doubts else "together they explain less than half of what is missing"

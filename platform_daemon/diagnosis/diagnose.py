"""The whole diagnosis of some shots of one specimen: from what is left over to what causes it, with proof."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from platform_daemon.estimation.models import RingDownModel
from platform_daemon.estimation.trajectory import LostTrajectoryError

from .effects.additive import LINE, MAINS, MAINS_HZ, MAINS_TOLERANCE
from .effects.base import Candidate
from .effects.clock import gap
from .effects.receiver import receiver_candidates
from .effects.torque import drift_candidate, stribeck_candidates, torque_candidates
from .generic import residues
from .heldout import HeldOut, held_out
from .hypothesis import Hypothesis
from .integrity import Flaw, flaws, without_gaps
from .lookalikes import Rival, gain_of, rivals
from .missing_torque import MissingTorque, missing_torque
from .parameters import Mean, means, window_disagreement
from .picture import Picture
from .pool import shot_pool
from .proposals import Proposal, proposals
from .refit import Refit, carried, refit
from .search import Found, Progress, search
from .shots import Shot
from .significance import log_chance
from .start import Refused, start

Verdict = Literal["nothing_missing", "explained", "partly_explained", "unexplained"]

_CONFIDENT = 0.5  # share of what could be gained that named effects must explain to be named at all
_LEFT = math.log(1e-3)
_NEGLIGIBLE = 0.01  # of what is explained: what is left may be there without spoiling an explanation
_HERTZ_LAW_RAD = 0.5 * math.pi
_NOISY = 1.1  # chi^2 per degree of freedom from which something is left, whatever its form
_PATCH = 0.02  # of the largest gain: an effect that gains less mends what the largest does not quite explain
_OPTIONS = 4  # look-alikes that held-out data choose from


_Passed = dict[object, Rival]  # look-alikes that were fitted better, by the key of what predicts better


class DiagnosisError(ValueError):
    """The shots cannot be diagnosed: what was seen is in the text."""


@dataclass(frozen=True)
class Named:
    """An accepted effect.

    strength, std: in the effect's unit. held_out_gain: fall of the held-out chi^2 that it brings as the last one.
    """

    candidate: Candidate
    strength: float
    std: float
    log_p: float
    held_out_gain: float
    alike: tuple[Rival, ...]


@dataclass(frozen=True)
class Diagnosis:
    """Everything that was found out, for reports."""

    shots: tuple[Shot, ...]
    refused: tuple[Refused, ...]
    model: RingDownModel
    verdict: Verdict
    named: tuple[Named, ...]
    integrity: tuple[Flaw, ...]
    found: Found
    final: Refit
    before: HeldOut
    after: HeldOut
    parameters_before: dict[str, Mean]
    parameters_after: dict[str, Mean]
    sigma_before: dict[str, float]
    sigma_after: dict[str, float]
    torque: MissingTorque | None
    next_measurements: tuple[Proposal, ...]
    notes: tuple[str, ...]
    seconds: float


def diagnose(shots: Sequence[Shot], model: RingDownModel, tell: Progress = lambda what, share: None) -> Diagnosis:
    """Diagnose shots of one specimen that all obey the same declared model.

    tell: called with what is being done and the share that is finished.

    Raises:
        DiagnosisError: no shot can be fitted by the declared model.
    """
    began = time.perf_counter()
    with shot_pool() as pool:
        return _diagnose(list(shots), model, tell, pool, began)


def _diagnose(shots: list[Shot], model: RingDownModel, tell: Progress, pool: Executor, began: float) -> Diagnosis:
    tell("checks of the data", 0.0)
    flawed = flaws(shots)
    bad = {f.shot for f in flawed}
    started, refused = start([s for k, s in enumerate(shots) if k not in bad], model, pool)
    if not started:
        why = "; ".join(dict.fromkeys(r.reason for r in refused)) or "; ".join(f.where for f in flawed)
        raise DiagnosisError(f"no shot can be fitted by the declared model {model.name}: {why}")
    started, gaps = without_gaps(started, model, pool)
    tell("fit of the declared model", 0.1)
    base = refit(started, Hypothesis(model), pool)
    found = search(base, candidates_for(base), pool, tell)
    tell("prediction of held-out data", 0.8)
    seen, before, after, dropped, passed = _proved(found, pool)
    final = seen.refit
    if final is not found.best:
        found = replace(found, residues=residues(final, pool))
    named = _named(found, seen, after, passed, pool) if final.hypothesis.effects else ()
    verdict = _verdict(found, final, named, gaps)
    if verdict == "unexplained":
        named = ()
    tell("parameters before and after", 0.9)
    left = found.residues
    torque = missing_torque(final, left) if verdict in ("unexplained", "partly_explained") else None
    sets = [
        (n.candidate, [r.candidate for r in n.alike], _rise(n), gain_of(final, n.candidate)) for n in named if n.alike
    ]
    return Diagnosis(
        shots=tuple(shots),
        refused=tuple(refused),
        model=model,
        verdict=verdict,
        named=(*named, *_gap_effects(gaps)),
        integrity=(*flawed, *gaps),
        found=found,
        final=final,
        before=before,
        after=after,
        parameters_before=means(base),
        parameters_after=means(final),
        sigma_before=window_disagreement(base, pool),
        sigma_after=window_disagreement(final, pool),
        torque=torque,
        next_measurements=tuple(
            proposals(sets, left.excess if verdict in ("unexplained", "partly_explained") else 0.0)
        ),
        notes=_notes(found, final, refused, dropped),
        seconds=time.perf_counter() - began,
    )


def _rise(named: Named) -> float:
    """Of chi^2 for the look-alike that is told apart least."""
    return min((r.rise for r in named.alike), default=0.0)


def candidates_for(base: Refit) -> list[Candidate]:
    """Everything with a name that can act on such shots; additive effects are found by the search itself."""
    model, record = base.hypothesis.model, base.started[0].shot.record
    small = all(abs(s.dynamics.amplitude) < _HERTZ_LAW_RAD for s in base.states)
    found = [*torque_candidates(model, jewel_law=small), drift_candidate(), *stribeck_candidates(model)]
    f_nat_hz = float(np.mean([s.dynamics.w for s in base.states])) / (2.0 * math.pi)
    return [*found, *receiver_candidates(record.channels, record.quantity, f_nat_hz)]


def _proved(found: Found, pool: Executor) -> tuple[Picture, HeldOut, HeldOut, tuple[Candidate, ...], _Passed]:
    """The picture of the refit that predicts best, without effects that do not help; held-out scores before and after.

    Where effects cannot be told apart by the fit, held-out data choose. With what was dropped, and what was passed over
    for a look-alike.
    """
    before = held_out(found.base, pool)
    (seen, passed), dropped = _best_predicting(found, pool), []
    after = held_out(seen.refit, pool) if seen.refit.hypothesis.effects else before
    while seen.refit.hypothesis.effects:
        at = seen.refit
        helps = {c.key: _help(at, c, after, found.base, pool) for c in at.hypothesis.effects}
        worst = min(at.hypothesis.effects, key=lambda c: helps[c.key])
        if helps[worst.key] > 0.0:
            break
        dropped.append(worst)
        final = found.base if len(at.hypothesis.effects) == 1 else _without(at, worst, found.base, pool)
        seen = found.look_again(final)
        after = held_out(final, pool) if final.hypothesis.effects else before
    return seen, before, after, tuple(dropped), passed


def _best_predicting(found: Found, pool: Executor) -> tuple[Picture, _Passed]:
    """The best refit, or one with look-alikes that predicts better; what was passed over for them."""
    seen, passed = found.picture, _Passed()
    for effect in seen.refit.hypothesis.common:
        options = [seen.refit]
        options += [r.refit for r in rivals(seen, effect, pool) if r.indistinguishable and r.refit is not None][
            :_OPTIONS
        ]
        if len(options) > 1:
            first = held_out(options[0], pool)
            best = min(options, key=lambda o: held_out(o, pool).worse_by(first))
            if best is not seen.refit:
                rise = (seen.refit.chi2 - best.chi2) / best.noise_factor
                kept = {c.key for c in seen.refit.hypothesis.effects}
                (new,) = (c for c in best.hypothesis.effects if c.key not in kept)
                passed[new.key] = Rival(effect, rise, gain_of(seen.refit, effect), seen.refit)
                seen = found.look_again(best)
    return seen, passed


def _without(at: Refit, effect: Candidate, base: Refit, pool: Executor) -> Refit:
    """A refit with all effects but one."""
    hypothesis = at.hypothesis.without(effect)
    if not hypothesis.effects:
        return base
    try:
        found = refit(at.started, hypothesis, pool, at.states, carried(at, hypothesis))
    except LostTrajectoryError:
        found = base
    # Far from what the shots do without it, the way down leads from their own fits.
    return found if found.chi2 < base.chi2 else refit(at.started, hypothesis, pool)


def _help(at: Refit, effect: Candidate, with_it: HeldOut, base: Refit, pool: Executor) -> float:
    """Fall of the held-out chi^2 that an effect brings as the last one."""
    return held_out(_without(at, effect, base, pool), pool).worse_by(with_it)


def _named(found: Found, seen: Picture, after: HeldOut, passed: _Passed, pool: Executor) -> tuple[Named, ...]:
    """Accepted effects with their evidence."""
    named, final = [], seen.refit
    f_nat = float(np.mean([s.dynamics.w for s in final.states])) / (2.0 * math.pi)
    friction = _mean_friction(final)
    for c in final.hypothesis.effects:
        alike: tuple[Rival, ...] = ()
        if c in final.hypothesis.common:
            where = next(s for o, s in zip(final.hypothesis.common, final.hypothesis.slices, strict=True) if o is c)
            value, std = _strength(c, final, where)
            value, std = c.public(value, std, f_nat, friction)
            log_p = log_chance(gain_of(final, c), c.size, found.trials * c.trials)
            alike = tuple(r for r in rivals(seen, c, pool) if r.indistinguishable)
            alike += (passed[c.key],) if c.key in passed else ()
        else:
            value, std, log_p = _own_strength(c, final, found.trials)
            alike = _named_alike(c)
        named.append(Named(c, value, std, log_p, _help(final, c, after, found.base, pool), alike))
    return tuple(named)


def _named_alike(c: Candidate) -> tuple[Rival, ...]:
    """A single line at a multiple of the mains may be either."""
    frequency = c.detail.frequency_hz or 0.0
    if c.effect is LINE and any(_is_multiple(frequency, mains) for mains in MAINS_HZ):
        return (Rival(replace(c, effect=MAINS), 0.0, 0.0),)
    return (Rival(replace(c, effect=LINE), 0.0, 0.0),) if c.effect is MAINS and len(c.tones_hz) == 1 else ()


def _is_multiple(frequency_hz: float, mains_hz: float) -> bool:
    """As near as the mains wanders."""
    return abs(frequency_hz / mains_hz - round(frequency_hz / mains_hz)) * mains_hz < MAINS_TOLERANCE * frequency_hz


def _strength(c: Candidate, final: Refit, where: slice) -> tuple[float, float]:
    """One number for the strength: the strength itself, or the amplitude of an additive effect."""
    values, covariance = final.strengths[where], final.covariance[where, where] * final.noise_factor
    if c.size == 1:
        return float(values[0]), float(np.sqrt(covariance[0, 0]))
    return _amplitude(values, covariance, pairs=c.detail.frequency_hz is not None)


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


def _own_strength(c: Candidate, final: Refit, trials: float) -> tuple[float, float, float]:
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


def _mean_friction(final: Refit) -> float:
    """Mean T_f/I of the declared model in rad/s^2; NaN without one."""
    names = [c.name for c in final.hypothesis.model.coefficients]
    if "tf_over_i_rad_per_s2" not in names:
        return math.nan
    place = names.index("tf_over_i_rad_per_s2")
    return float(np.mean([s.dynamics.values[place] for s in final.states]))


def _verdict(found: Found, final: Refit, named: tuple[Named, ...], gaps: Sequence[Flaw]) -> Verdict:
    """From what is explained and what is left."""
    left, factor = found.residues, final.noise_factor
    explained = max(found.base.chi2 - final.chi2, 0.0) / factor
    excess = max(left.excess, (final.chi2 - final.dof) / factor if factor > _NOISY else 0.0)
    significant = math.log(max(left.p_value, 1e-300)) < _LEFT and left.excess > _NEGLIGIBLE * explained
    significant |= factor > _NOISY
    if not named:
        if significant or found.forbidden or found.best.hypothesis.effects:
            return "unexplained"
        return "explained" if gaps else "nothing_missing"
    share = explained / (explained + excess)
    if significant and share < _CONFIDENT:
        return "unexplained"
    gains = [gain_of(final, n.candidate) for n in named if n.candidate in final.hypothesis.common]
    patched = len(gains) > 1 and min(gains) < _PATCH * max(gains)
    doubtful = significant or found.forbidden or final.hypothesis.gone or patched
    return "partly_explained" if doubtful else "explained"


def _gap_effects(gaps: Sequence[Flaw]) -> list[Named]:
    """Clock gaps, one effect for each place, as mean over the shots that show it."""
    found = []
    for at in dict.fromkeys(f.at for f in gaps):
        same = [f for f in gaps if f.at == at]
        value = float(np.mean([f.value or 0.0 for f in same]))
        std = float(np.sqrt(np.sum([(f.sd or 0.0) ** 2 for f in same]))) / len(same)
        found.append(Named(gap(at or 0), value, std, min(f.log_p for f in same), 0.0, ()))
    return found


def _notes(found: Found, final: Refit, refused: Sequence[Refused], dropped: Sequence[Candidate]) -> tuple[str, ...]:
    """What the reader should know besides."""
    notes = [f"{r.shot.name} was left out: {r.reason}" for r in refused]
    if len(final.started) == 1:
        notes.append("one shot only: held out is the last 30 % of its window, predicted from the first 70 %")
    notes += [c.effect.absorbed for c in final.hypothesis.effects if c.effect.absorbed]
    notes += [f"{c.effect.id} gains in the fit but not on held-out data, and was not accepted" for c in dropped]
    if found.forbidden:
        names = " and ".join(c.effect.id for c in found.forbidden)
        notes.append(f"the best fit is with {names} of a sign that physics does not allow")
    if final.hypothesis.gone:
        names = " and ".join(final.hypothesis.model.coefficients[k].name for k in final.hypothesis.gone)
        notes.append(f"{names} is held at 0: beside these effects the best fit has it negative, which physics forbids")
    if final.noise_factor > 1.05:
        notes.append(f"chi2/dof stays at {final.noise_factor:.3g}: errors and chances are widened accordingly")
    return tuple(notes)

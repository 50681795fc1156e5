"""The refit that predicts held-out data best, and its effects that help there."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.cross_validation import CrossValidation, cross_validate
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly, starting_point
from platform_daemon.diagnosis.regression.score_test import ScoreTable
from platform_daemon.diagnosis.selection.amplitude_laws import is_timed, time_is_doubtful
from platform_daemon.diagnosis.selection.confounders import Confounder, confounders, gain_of
from platform_daemon.diagnosis.selection.sign_constraints import without_gain_of_energy
from platform_daemon.diagnosis.selection.significance import log_chance
from platform_daemon.diagnosis.selection.stepwise import Selection
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

_LIMITS = THRESHOLDS.validation
_LIKELY = math.log(_LIMITS.dropped_p)
ReplacedEffects = dict[object, tuple[Confounder, ...]]  # what a look-alike has replaced, by the look-alike's key


def validate_effects(
    found: Selection, pool: Executor
) -> tuple[ScoreTable, CrossValidation, CrossValidation, tuple[Candidate, ...], ReplacedEffects]:
    """Score table of the refit that predicts best, without effects that do not help; held-out scores before and after.

    Where the fit cannot distinguish effects, held-out data choose. The last two results are the effects that were
    dropped, and those that a look-alike has replaced.
    """
    before = cross_validate(found.base, pool)
    (table, replaced), dropped = _best_predicting(_still_sure(found, pool), pool), []
    if replaced:
        table = _still_sure(replace(found, best=table.joint_fit, score_table=table), pool).score_table
        left = {c.key for c in table.joint_fit.hypothesis.effects}
        replaced = {key: others for key, others in replaced.items() if key in left}
    after = cross_validate(table.joint_fit, pool) if table.joint_fit.hypothesis.effects else before
    while table.joint_fit.hypothesis.effects:
        at = table.joint_fit
        helps = {c.key: held_out_gain_of(at, c, after, found.base, pool) for c in at.hypothesis.effects}
        worst = min(at.hypothesis.effects, key=lambda c: helps[c.key])
        if helps[worst.key] > 0.0:
            break
        dropped.append(worst)
        final = found.base if len(at.hypothesis.effects) == 1 else without(at, worst, found.base, pool)
        table = found.score_table_of(final)
        after = cross_validate(final, pool) if final.hypothesis.effects else before
    return table, before, after, tuple(dropped), replaced


def _still_sure(found: Selection, pool: Executor) -> Selection:
    """Without effects that are no longer significant given those that were found later.

    Lines near the motion's own frequency stand for an effect on the motion until that is found, so that of effects
    that are alike insignificant a shot's own goes first.
    """
    best = found.best
    while best.hypothesis.effects:
        chances = {c.key: log_chance_of(best, c, found, pool) for c in best.hypothesis.effects}
        worst = max(best.hypothesis.effects, key=lambda c: (chances[c.key], c in best.hypothesis.own))
        if chances[worst.key] < _LIKELY:
            break
        try:
            best = without(best, worst, found.base, pool)
        except (LostTrajectoryError, np.linalg.LinAlgError):  # it is needed to follow the motion
            break
    return found if best is found.best else replace(found, best=best, score_table=found.score_table_of(best))


def log_chance_of(at: JointFit, effect: Candidate, found: Selection, pool: Executor) -> float:
    """Logarithm of the chance that noise alone gains as much as an accepted effect does as the last one.

    found: the search, which tells how much was tried.
    """
    trials = found.trials * effect.trials
    if effect not in at.hypothesis.own:
        return log_chance(gain_of(at, effect), effect.size, trials)
    # Its columns may nearly be those of the motion, so that what they hold is not what they gain.
    assert effect.columns is not None
    try:
        fall = without(at, effect, found.base, pool).chi2 - at.chi2
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return -math.inf
    return log_chance(fall / at.noise_factor, sum(len(effect.columns(a.linearisation)) for a in at.linear), trials)


def _best_predicting(found: Selection, pool: Executor) -> tuple[ScoreTable, ReplacedEffects]:
    """The best refit, or one with look-alikes that predicts better; the effects that they have replaced."""
    table, replaced = found.score_table, ReplacedEffects()
    for effect in table.joint_fit.hypothesis.common:
        doubtful = time_is_doubtful(table.joint_fit) and not is_timed(effect)
        look_alikes = [
            r
            for r in confounders(table, effect, pool)
            if r.indistinguishable and _sure(r, found, pool) and not (doubtful and is_timed(r.candidate))
        ]
        if not look_alikes:
            continue
        first, gain = cross_validate(table.joint_fit, pool), gain_of(table.joint_fit, effect)
        scores = [(_worse(r, first, pool), r) for r in look_alikes[: _LIMITS.compared_look_alikes]]
        worse, best = min(scores, key=lambda pair: pair[0], default=(0.0, None))
        if best is not None and best.joint_fit is not None and worse < -_LIMITS.better_chi2:
            others = [
                Confounder(candidate=effect, rise=0.0, gain=gain, joint_fit=table.joint_fit),
                *(r for r in look_alikes if r is not best),
            ]
            replaced[best.candidate.key] = tuple(replace(r, rise=r.rise - best.rise) for r in others)
            table = found.score_table_of(best.joint_fit)
    return table, replaced


def _sure(rival: Confounder, found: Selection, pool: Executor) -> bool:
    """True if the look-alike itself is significant after correction for all places that were searched."""
    return rival.joint_fit is not None and log_chance_of(rival.joint_fit, rival.candidate, found, pool) < _LIKELY


def _worse(rival: Confounder, first: CrossValidation, pool: Executor) -> float:
    """Rise of the held-out chi^2 with a look-alike."""
    return 0.0 if rival.joint_fit is None else cross_validate(rival.joint_fit, pool).worse_by(first)


def without(at: JointFit, effect: Candidate, base: JointFit, pool: Executor) -> JointFit:
    """A refit with all effects but one."""
    hypothesis = at.hypothesis.without(effect)
    if not hypothesis.effects:
        return base
    try:
        found = fit_jointly(at.prepared, hypothesis, pool, *starting_point(at, hypothesis))
    except (LostTrajectoryError, np.linalg.LinAlgError):
        found = base
    # Far from what the shots do without it, the way down leads from their own fits.
    found = found if found.chi2 < base.chi2 else fit_jointly(at.prepared, hypothesis, pool)
    return without_gain_of_energy(found, pool)


def held_out_gain_of(
    at: JointFit, effect: Candidate, with_it: CrossValidation, base: JointFit, pool: Executor
) -> float:
    """Fall of the held-out chi^2 that an effect brings as the last one."""
    return cross_validate(without(at, effect, base, pool), pool).worse_by(with_it)

"""Which of the refits predicts data that were not used, and which effects of it help there."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation import LostTrajectoryError

from ..effects.effect import Candidate
from ..regression.cross_validation import CrossValidation, cross_validate
from ..regression.joint_fit import JointFit, fit_jointly, starting_point
from ..regression.score_test import ScoreTable
from ..selection.confounders import Confounder, confounders, gain_of
from ..selection.sign_constraints import without_gain_of_energy
from ..selection.significance import log_chance
from ..selection.stepwise import Selection

_LIKELY = math.log(0.05)  # logarithm of a chance above which an effect is dropped again
_OPTIONS = 4  # look-alikes that held-out data choose from
_BETTER = 2.0  # fall of the held-out chi^2 for which a look-alike takes the place of what is fitted best
ReplacedEffects = dict[object, tuple[Confounder, ...]]  # what was passed over for a look-alike, by the look-alike's key


def validate_effects(
    found: Selection, pool: Executor
) -> tuple[ScoreTable, CrossValidation, CrossValidation, tuple[Candidate, ...], ReplacedEffects]:
    """Score table of the refit that predicts best, without effects that do not help; held-out scores before and after.

    Where effects cannot be told apart by the fit, held-out data choose. With what was dropped, and what was passed over
    for a look-alike.
    """
    before = cross_validate(found.base, pool)
    (seen, passed), dropped = _best_predicting(_still_sure(found, pool), pool), []
    after = cross_validate(seen.joint_fit, pool) if seen.joint_fit.hypothesis.effects else before
    while seen.joint_fit.hypothesis.effects:
        at = seen.joint_fit
        helps = {c.key: held_out_gain_of(at, c, after, found.base, pool) for c in at.hypothesis.effects}
        worst = min(at.hypothesis.effects, key=lambda c: helps[c.key])
        if helps[worst.key] > 0.0:
            break
        dropped.append(worst)
        final = found.base if len(at.hypothesis.effects) == 1 else without(at, worst, found.base, pool)
        seen = found.score_table_of(final)
        after = cross_validate(final, pool) if final.hypothesis.effects else before
    return seen, before, after, tuple(dropped), passed


def _still_sure(found: Selection, pool: Executor) -> Selection:
    """Without common effects that no longer gain beside those that were found, or sharpened, after them."""
    best = found.best
    while best.hypothesis.common:
        chances = {c: _log_chance(best, c, found.trials) for c in best.hypothesis.common}
        worst = max(best.hypothesis.common, key=lambda c: chances[c])
        if chances[worst] < _LIKELY:
            break
        best = without(best, worst, found.base, pool)
    return found if best is found.best else replace(found, best=best, score_table=found.score_table_of(best))


def _log_chance(at: JointFit, effect: Candidate, trials: float) -> float:
    return log_chance(gain_of(at, effect), effect.size, trials * effect.trials)


def _best_predicting(found: Selection, pool: Executor) -> tuple[ScoreTable, ReplacedEffects]:
    """The best refit, or one with look-alikes that predicts better; what was passed over for them."""
    seen, passed = found.score_table, ReplacedEffects()
    for effect in seen.joint_fit.hypothesis.common:
        alike = [r for r in confounders(seen, effect, pool) if r.indistinguishable and _sure(r, found.trials)]
        if not alike:
            continue
        first, gain = cross_validate(seen.joint_fit, pool), gain_of(seen.joint_fit, effect)
        scores = [(_worse(r, first, pool), r) for r in alike[:_OPTIONS]]
        worse, best = min(scores, key=lambda pair: pair[0], default=(0.0, None))
        if best is not None and best.joint_fit is not None and worse < -_BETTER:
            others = [Confounder(effect, 0.0, gain, seen.joint_fit), *(r for r in alike if r is not best)]
            passed[best.candidate.key] = tuple(replace(r, rise=r.rise - best.rise) for r in others)
            seen = found.score_table_of(best.joint_fit)
    return seen, passed


def _sure(rival: Confounder, trials: float) -> bool:
    """It is no chance by itself: of what is looked for at many places, some place nearly always gains a little."""
    return rival.joint_fit is not None and _log_chance(rival.joint_fit, rival.candidate, trials) < _LIKELY


def _worse(rival: Confounder, first: CrossValidation, pool: Executor) -> float:
    """Rise of the held-out chi^2 with a look-alike."""
    return 0.0 if rival.joint_fit is None else cross_validate(rival.joint_fit, pool).worse_by(first)


def without(at: JointFit, effect: Candidate, base: JointFit, pool: Executor) -> JointFit:
    """A refit with all effects but one."""
    hypothesis = at.hypothesis.without(effect)
    if not hypothesis.effects:
        return base
    try:
        found = fit_jointly(at.started, hypothesis, pool, *starting_point(at, hypothesis))
    except (LostTrajectoryError, np.linalg.LinAlgError):
        found = base
    # Far from what the shots do without it, the way down leads from their own fits.
    found = found if found.chi2 < base.chi2 else fit_jointly(at.started, hypothesis, pool)
    return without_gain_of_energy(found, pool)


def held_out_gain_of(
    at: JointFit, effect: Candidate, with_it: CrossValidation, base: JointFit, pool: Executor
) -> float:
    """Fall of the held-out chi^2 that an effect brings as the last one."""
    return cross_validate(without(at, effect, base, pool), pool).worse_by(with_it)

"""Which of the refits predicts data that were not used, and which effects of it help there."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from ..effects.effect import Candidate
from ..regression.joint_fit import Refit, following, refit
from ..regression.score_test import Picture
from ..selection.confounders import Rival, gain_of, rivals
from ..selection.sign_constraints import without_gain_of_energy
from ..selection.stepwise import Found
from .cross_validation import HeldOut, held_out

_OPTIONS = 4  # look-alikes that held-out data choose from
_BETTER = 2.0  # fall of the held-out chi^2 for which a look-alike takes the place of what is fitted best
Passed = dict[object, tuple[Rival, ...]]  # what was passed over for a look-alike, by the look-alike's key


def proved(found: Found, pool: Executor) -> tuple[Picture, HeldOut, HeldOut, tuple[Candidate, ...], Passed]:
    """The picture of the refit that predicts best, without effects that do not help; held-out scores before and after.

    Where effects cannot be told apart by the fit, held-out data choose. With what was dropped, and what was passed over
    for a look-alike.
    """
    before = held_out(found.base, pool)
    (seen, passed), dropped = _best_predicting(found, pool), []
    after = held_out(seen.refit, pool) if seen.refit.hypothesis.effects else before
    while seen.refit.hypothesis.effects:
        at = seen.refit
        helps = {c.key: help_of(at, c, after, found.base, pool) for c in at.hypothesis.effects}
        worst = min(at.hypothesis.effects, key=lambda c: helps[c.key])
        if helps[worst.key] > 0.0:
            break
        dropped.append(worst)
        final = found.base if len(at.hypothesis.effects) == 1 else without(at, worst, found.base, pool)
        seen = found.look_again(final)
        after = held_out(final, pool) if final.hypothesis.effects else before
    return seen, before, after, tuple(dropped), passed


def _best_predicting(found: Found, pool: Executor) -> tuple[Picture, Passed]:
    """The best refit, or one with look-alikes that predicts better; what was passed over for them."""
    seen, passed = found.picture, Passed()
    for effect in seen.refit.hypothesis.common:
        alike = [r for r in rivals(seen, effect, pool) if r.indistinguishable and r.refit is not None]
        if not alike:
            continue
        first, gain = held_out(seen.refit, pool), gain_of(seen.refit, effect)
        scores = [(_worse(r, first, pool), r) for r in alike[:_OPTIONS]]
        worse, best = min(scores, key=lambda pair: pair[0], default=(0.0, None))
        if best is not None and best.refit is not None and worse < -_BETTER:
            others = [Rival(effect, 0.0, gain, seen.refit), *(r for r in alike if r is not best)]
            passed[best.candidate.key] = tuple(replace(r, rise=r.rise - best.rise) for r in others)
            seen = found.look_again(best.refit)
    return seen, passed


def _worse(rival: Rival, first: HeldOut, pool: Executor) -> float:
    """Rise of the held-out chi^2 with a look-alike."""
    return 0.0 if rival.refit is None else held_out(rival.refit, pool).worse_by(first)


def without(at: Refit, effect: Candidate, base: Refit, pool: Executor) -> Refit:
    """A refit with all effects but one."""
    hypothesis = at.hypothesis.without(effect)
    if not hypothesis.effects:
        return base
    try:
        found = refit(at.started, hypothesis, pool, *following(at, hypothesis))
    except (LostTrajectoryError, np.linalg.LinAlgError):
        found = base
    # Far from what the shots do without it, the way down leads from their own fits.
    found = found if found.chi2 < base.chi2 else refit(at.started, hypothesis, pool)
    return without_gain_of_energy(found, pool)


def help_of(at: Refit, effect: Candidate, with_it: HeldOut, base: Refit, pool: Executor) -> float:
    """Fall of the held-out chi^2 that an effect brings as the last one."""
    return held_out(without(at, effect, base, pool), pool).worse_by(with_it)

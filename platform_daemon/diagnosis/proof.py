"""Which of the refits predicts data that were not used, and which effects of it help there."""

from __future__ import annotations

from concurrent.futures import Executor

from platform_daemon.estimation.trajectory import LostTrajectoryError

from .effects.base import Candidate
from .heldout import HeldOut, held_out
from .lookalikes import Rival, gain_of, rivals
from .picture import Picture
from .refit import Refit, carried, refit
from .search import Found

_OPTIONS = 4  # look-alikes that held-out data choose from
Passed = dict[object, Rival]  # look-alikes that were fitted better, by the key of what predicts better


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


def without(at: Refit, effect: Candidate, base: Refit, pool: Executor) -> Refit:
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


def help_of(at: Refit, effect: Candidate, with_it: HeldOut, base: Refit, pool: Executor) -> float:
    """Fall of the held-out chi^2 that an effect brings as the last one."""
    return held_out(without(at, effect, base, pool), pool).worse_by(with_it)

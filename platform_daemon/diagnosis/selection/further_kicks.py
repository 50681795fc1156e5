"""Several kicks in one swing: one after the other, each where it gains most beside those before it.

A set of effects holds each effect once, whatever its places.  The first kick of several explains only its own part, and
a law that follows the amplitude may explain more than it; all of them together leave noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor

from platform_daemon.diagnosis.effects.kick import KICK
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS

from .kick_search import kick_missing, kicks
from .refits import allowed_refit, refined
from .sign_constraints import signs_allowed
from .significance import LEVEL, log_chance

_LIMITS = THRESHOLDS.selection


def with_further_kicks(fits: Sequence[JointFit], smaller: JointFit | None, pool: Executor) -> list[JointFit]:
    """Fits of a size, the best first, and the best of them with a kick, and the best smaller one, with all their kicks.

    smaller: the best fit with one effect less; None: of the declared model, whose kicks are among the fits, or tried.
    """
    begun = [f for f in fits if _count(f)][:1]
    if smaller is not None and not _count(smaller):
        begun.append(smaller)
    found = [f for at in begun if (f := _with_all_kicks(at, pool)) is not at]
    return sorted([*fits, *found], key=lambda f: f.chi2)


def _with_all_kicks(at: JointFit, pool: Executor) -> JointFit:
    """With so many kicks that only noise is left, each of which is seen at its instant; itself where there are none.

    Until all of them are there the others make the residual large and slow, and would hide each other.  Many kicks
    also imitate a law of the amplitude: what they leave then is no noise.
    """
    begun = at
    while _count(at) < _LIMITS.most_kicks and not at.leaves_noise:
        found = [f for c in kicks(at) if (f := allowed_refit(at.hypothesis.plus(c), at, pool)) is not None]
        if not found:
            break
        more = refined(min(found, key=lambda f: f.chi2), pool)
        trials = float(at.linear[0].linearisation.time_s.size)
        if log_chance((at.chi2 - more.chi2) / max(1.0, more.chi2_per_dof), 1, trials) >= LEVEL:
            break
        at = more
    return at if at.leaves_noise and not kick_missing(at) and signs_allowed(at) else begun


def _count(at: JointFit) -> int:
    """Of its kicks."""
    return sum(c.effect is KICK for c in at.hypothesis.effects)

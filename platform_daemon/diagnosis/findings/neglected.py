"""An effect that is surely there beside those that were named, and too small beside them to be believed by its name."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

from ..effects.effect import Candidate
from ..regression.joint_fit import JointFit
from ..regression.score_test import ScoreTable
from ..selection.refits import allowed_refit
from ..selection.sign_constraints import signs_allowed, step_allowed
from ..selection.significance import LEVEL, log_chance
from ..selection.subsets import singles

_TRIED = 2  # candidates that gain most, to first order


@dataclass(frozen=True)
class Neglected:
    """What was left out, what chi^2 falls by with it, and the joint fit that has it."""

    candidate: Candidate
    fall: float
    joint_fit: JointFit

    @property
    def note(self) -> str:
        """For the reader."""
        return (
            f"{self.candidate.effect.id} gains {self.fall:.0f} of chi2, little beside what the named effects gain: "
            "it may only mend these, and is not named; the errors of the parameters span it"
        )


def neglected(seen: ScoreTable, dropped: Sequence[Candidate], trials: float, pool: Executor) -> list[Neglected]:
    """What a search passes over because it is small beside what was found, one at a time, the best first.

    Nothing is said beside effects with a hidden scale: what that leaves, being a little off, is as large.
    seen: scores beside the last fit. dropped: effects that do not predict, which are no candidates.
    """
    final, gone = seen.joint_fit, {c.key for c in dropped}
    if any(c.hidden for c in final.hypothesis.common):
        return []
    offered = [(blocks[0].candidate, s) for blocks, s in singles(seen) if step_allowed(blocks, s)]
    sure = [c for c, s in offered if c.key not in gone and log_chance(s.gain, c.size, trials * c.trials) < LEVEL]
    # Torques that depend on time take long: only one that gains most.
    tried = [c for k, c in enumerate(sure[:_TRIED]) if k == 0 or c.term is None or not c.term.timed]
    found = []
    for c in tried:
        fit = allowed_refit(final.hypothesis.plus(c), final, pool)
        # Scores of first order are in doubt where others are large; a refit is not.
        fall = 0.0 if fit is None else (final.chi2 - fit.chi2) / fit.noise_factor
        if fit is not None and signs_allowed(fit) and log_chance(fall, c.size, trials * c.trials) < LEVEL:
            found.append(Neglected(c, fall, fit))
    return sorted(found, key=lambda one: -one.fall)

"""Significant effects that are too small next to the named ones to be named."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.score_test import ScoreTable
from platform_daemon.diagnosis.selection.refits import allowed_refit
from platform_daemon.diagnosis.selection.sign_constraints import signs_allowed, step_allowed
from platform_daemon.diagnosis.selection.significance import LEVEL, log_chance
from platform_daemon.diagnosis.selection.subsets import singles
from platform_daemon.diagnosis.thresholds import THRESHOLDS

_LIMITS = THRESHOLDS.findings


@dataclass(frozen=True)
class NegligibleEffect:
    """An effect that is not named, the fall of chi^2 that it brings, and the joint fit that contains it."""

    candidate: Candidate
    fall: float
    joint_fit: JointFit

    @property
    def note(self) -> str:
        """Sentence for the report."""
        return (
            f"{self.candidate.effect.id} gains {self.fall:.0f} of chi2, little beside what the named effects gain: "
            "it may only mend these, and is not named; the errors of the parameters span it"
        )


def negligible_effects(
    table: ScoreTable, dropped: Sequence[Candidate], trials: float, pool: Executor
) -> list[NegligibleEffect]:
    """Effects below the relative threshold of the search that a refit finds significant, one at a time, best first.

    Empty if a named effect has a hidden scale: the residual of a scale that is slightly off is as large.
    table: scores given the last fit. dropped: effects that do not predict, which are no candidates.
    """
    final = table.joint_fit
    dropped_keys = {c.key for c in dropped}
    if any(c.hidden for c in final.hypothesis.common):
        return []
    offered = [(blocks[0].candidate, s) for blocks, s in singles(table) if step_allowed(blocks, s)]
    sure = [
        c for c, s in offered if c.key not in dropped_keys and log_chance(s.gain, c.size, trials * c.trials) < LEVEL
    ]
    # Torques that depend on time take long: only one that gains most.
    tried = [c for k, c in enumerate(sure[: _LIMITS.negligible_tried]) if k == 0 or c.term is None or not c.term.timed]
    found = []
    for c in tried:
        fit = allowed_refit(final.hypothesis.plus(c), final, pool)
        # Scores of first order are in doubt where others are large; a refit is not.
        fall = 0.0 if fit is None else (final.chi2 - fit.chi2) / fit.noise_factor
        if fit is not None and signs_allowed(fit) and log_chance(fall, c.size, trials * c.trials) < LEVEL:
            found.append(NegligibleEffect(c, fall, fit))
    return sorted(found, key=lambda one: -one.fall)

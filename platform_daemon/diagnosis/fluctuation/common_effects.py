"""Effects that all shots have in common beside their courses: a linear test that asks whether they are common.

What fluctuates faster than the knots of a course acts like one effect or another, in each shot with another size.  Of
such an effect the sizes of single shots differ by more than their errors; with f the chi^2 of these differences per
degree of freedom, f > 1, its gain counts f times less.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.linearised_shot import LinearisedShot, linearise_shot
from platform_daemon.diagnosis.regression.score_test import CandidateBlock, ScoreResult, score_table
from platform_daemon.diagnosis.selection.significance import LEVEL, log_chance
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.diagnosis.shots.torque_course import CourseState
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.fluctuation


def common_effects(
    base: JointFit, states: Sequence[CourseState], candidates: Sequence[Candidate], pool: Executor
) -> tuple[Hypothesis, Array]:
    """The effects that all shots have in common beside their courses, one after the other, with their strengths.

    At the states of the courses' fits the data are linear in all of them, so that nothing is fitted again in between.

    base: the fit of the declared model; states: of the courses' fits.  Raises LostTrajectoryError.
    """

    def one(shot: PreparedShot, state: CourseState) -> LinearisedShot:
        return linearise_shot(shot, base.hypothesis, state, base.strengths)

    linear = tuple(pool.map(one, base.prepared, states))
    at = replace(base, states=tuple(states), linear=linear)
    table = score_table(at, candidates, pool)
    chosen: list[CandidateBlock] = []
    passed: list[CandidateBlock] = []
    best: ScoreResult | None = None
    while len(chosen) < _LIMITS.most_effects:
        left = [b for b in table.blocks if b not in chosen and b not in passed]
        scores = [(score, b) for b in left if (score := table.gain([*chosen, b]))]
        scores = [(s, b) for s, b in scores if b.candidate.allows(float(s.strengths[-1]))]
        if not scores:
            break
        score, block = max(scores, key=lambda pair: pair[0].gain)
        more = (score.gain - (best.gain if best else 0.0)) * at.noise_factor
        size, trials = block.candidate.size, float(len(candidates))
        if log_chance(more, size, trials) >= LEVEL:
            break
        if log_chance(more / _spread(at, chosen, block, more, pool), size, trials) >= LEVEL:
            passed.append(block)
        else:
            chosen, best = [*chosen, block], score
    hypothesis = base.hypothesis.plus(*(b.candidate for b in chosen))
    strengths = np.zeros(hypothesis.size)
    if best is not None:
        sizes = dict(zip([b.candidate.key for b in chosen], _split(best.strengths, chosen), strict=True))
        for c, where in zip(hypothesis.common, hypothesis.slices, strict=True):
            strengths[where] = sizes[c.key]
    return hypothesis, strengths


def _spread(
    at: JointFit, chosen: Sequence[CandidateBlock], block: CandidateBlock, together: float, pool: Executor
) -> float:
    """chi^2 per degree of freedom of how the effect's sizes in single shots differ, at least 1.

    together: its gain with one size for all shots, beside the chosen ones.
    """
    candidates = [b.candidate for b in (*chosen, block)]

    def gain(k: int) -> float | None:
        alone = replace(at, prepared=(at.prepared[k],), states=(at.states[k],), linear=(at.linear[k],))
        table = score_table(alone, candidates, InlineExecutor())
        blocks = [b for b in table.blocks if b.candidate in candidates]
        with_it, without = table.gain(blocks), table.gain(blocks[:-1]) if chosen else None
        if with_it is None or (chosen and without is None):
            return None  # the shot tells nothing of it
        return (with_it.gain - (without.gain if without else 0.0)) * alone.noise_factor

    told = [each for each in pool.map(gain, range(len(at.prepared))) if each is not None]
    return max(1.0, (sum(told) - together) / (block.candidate.size * (len(told) - 1))) if len(told) > 1 else 1.0


def _split(strengths: Array, blocks: Sequence[CandidateBlock]) -> list[Array]:
    """Strengths of each block."""
    ends = np.cumsum([0, *(len(b.where) for b in blocks)])
    return [strengths[a:b] for a, b in itertools.pairwise(ends)]

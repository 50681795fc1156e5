"""Which effects explain what is left: score tests of everything, refits of the leaders, alone and in combination.

Effects are added until nothing significant is left, or nothing helps any more. Two effects that act together can hide
behind a third that mimics their sum; therefore sets of every size are drawn from the first score table too, not only by
adding to the best smaller set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from platform_daemon.estimation import Zones

from ..effects.effect import Candidate
from ..regression.hypothesis import Hypothesis
from ..regression.joint_fit import JointFit
from ..regression.score_test import CandidateBlock, ScoreResult, ScoreTable, score_table
from .component_search import shot_residuals, side_modes, steady_tones, tones, transients
from .omnibus_test import OmnibusTest, omnibus_test
from .refits import allowed_refit, own_gain, refined, refined_own, refit
from .scales import at_best_scales
from .sign_constraints import signs_allowed, step_allowed
from .significance import LEVEL, log_chance
from .subsets import pairs, singles, triples
from .torque_sets import best_torques

_LARGEST_SET = 3
_LEADERS = 6
_NEAR = 0.03  # share of the best gain within which another set may overtake it once refitted
_CLOSE = 12.0  # fall of chi^2, the same
_NEGLIGIBLE = 0.004  # of what is explained already: the digits of first-order corrections
_MOST_ADDITIVE = 6
_PER_SCALE = 4.0  # of chi^2, that a hidden scale must gain by being there
_LITTLE_LEFT = 1.1  # chi^2 per degree of freedom
_BESIDE_MOTION = 0.15  # of its frequency

ProgressCallback = Callable[[str, float], None]


@dataclass(frozen=True)
class CandidateTest:
    """A candidate set with its evidence."""

    candidates: tuple[Candidate, ...]
    strengths: tuple[float, ...]
    sd: tuple[float, ...]
    gain: float
    log_p: float
    allowed: bool


@dataclass(frozen=True)
class Selection:
    """The end of a search.

    Attributes:
        base: the joint fit of the declared model.
        best: the joint fit with everything that was accepted.
        score_table: of all other candidates beside it.
        omnibus_test: of what is left without a name.
        before: the same beside the declared model.
        tried: single candidates beside the declared model, best first.
        trials: number of candidates, by which chances are corrected.
        score_table_of: all candidates beside another refit.
        forbidden: the best set fits only with a sign that physics does not allow.
        passed_over: a set that fits far better, but does not predict what was not used.
    """

    base: JointFit
    best: JointFit
    score_table: ScoreTable
    omnibus_test: OmnibusTest
    before: OmnibusTest
    tried: tuple[CandidateTest, ...]
    trials: float
    score_table_of: Callable[[JointFit], ScoreTable]
    forbidden: tuple[Candidate, ...] = ()
    passed_over: JointFit | None = None


def select_effects(
    base: JointFit, candidates: Sequence[Candidate], pool: Executor, tell: ProgressCallback
) -> Selection:
    """Add effects to the declared model until nothing that has a name is left.

    candidates: torque and receiver candidates; additive ones are looked for here.

    Raises:
        LostTrajectoryError: the declared model itself describes no oscillation.
    """
    if base.started[0].shot.record.quantity != "angle" or base.chi2_per_dof < _LITTLE_LEFT:
        return _Search(base, list(candidates), pool, tell).run(base)
    every = _Search(base, list(candidates), pool, tell)
    motions = [c for c in candidates if c.change is None]
    begun, passed = best_torques(base, motions, float(len(candidates)), pool, tell)
    # Linear scores are right for torques too where little is left to be explained.
    rest = [c for c in candidates if c.term is None or begun.chi2_per_dof < _LITTLE_LEFT]
    beside = _Search(base, rest, pool, tell).run(begun)
    return replace(
        beside, tried=every.singles(every.score_table(base)), score_table=every.score_table(beside.best),
        score_table_of=every.score_table, passed_over=passed,
    )  # fmt: skip


@dataclass(frozen=True)
class _Own:
    """An effect that every shot has for itself, and the logarithm of its chance.

    Attributes:
        log_p: by the noise of what it leaves. beside: by that of what there is, as common effects are judged.
    """

    candidate: Candidate
    log_p: float
    beside: float


class _Search:
    """State of a search."""

    def __init__(self, base: JointFit, named: list[Candidate], pool: Executor, tell: ProgressCallback) -> None:
        self._base, self._named, self._pool, self._tell = base, named, pool, tell
        self._trials = float(len(named) + len(transients(base)) + 3)
        self._scanned: tuple[JointFit, tuple[list[Candidate], list[Candidate]]] | None = None

    def run(self, begun: JointFit) -> Selection:
        """Alternate between effects of each shot's own and sets of common ones, beside what was begun with."""
        before = omnibus_test(self._base, self._pool)
        self._tell("scores of all candidates", 0.25)
        root, best = begun, begun
        first = seen = self.score_table(root)
        tried = self.singles(first)
        forbidden: tuple[Candidate, ...] = ()
        size = additive = 0
        while True:
            own = self._best_own(best) if additive < _MOST_ADDITIVE else None
            common = self._best_common(seen)
            if own is not None and own.log_p < LEVEL and (common >= LEVEL or own.beside < common):
                # What stands beside the signal is taken out first: the sets start anew beside it.
                sharp = refined_own(best, own.candidate, self._pool)
                root = refit(root.hypothesis.plus(sharp), root, self._pool) or root
                best = refit(best.hypothesis.plus(sharp), best, self._pool) or best
                first = self.score_table(root)
                seen = first if size == 0 else self.score_table(best)
                additive += 1
                continue
            if common >= LEVEL or size == _LARGEST_SET:
                break
            size += 1
            self._tell(f"refits of sets of {size}", 0.3 + 0.15 * size)
            better, banned = self._grown(first, seen, best, size)
            if better is None:
                # Two effects can hide from every single one: larger sets are tried all the same.
                forbidden = banned or forbidden
                continue
            better, forbidden = at_best_scales(refined(better, self._pool), self._pool), ()
            best, seen = better, self.score_table(better)
        after = omnibus_test(best, self._pool) if best is not self._base else before
        return Selection(self._base, best, seen, after, before, tried, self._trials, self.score_table, forbidden)

    def _scan(self, at: JointFit) -> tuple[list[Candidate], list[Candidate]]:
        """(tones, side modes) in what a refit leaves over; looked for once."""
        if self._scanned is None or self._scanned[0] is not at:
            left = shot_residuals(at, self._pool)
            sides = side_modes(at, left)
            lines = [*tones(at, left), *steady_tones(at, sides)]
            sides = [c for c in sides if not self._steady(at, c, lines)]
            if at.started[0].shot.record.quantity == "angle":
                lines, sides = ([c for c in some if not _near_motion(c, at)] for some in (lines, sides))
            self._scanned = at, (lines, sides)
        return self._scanned[1]

    def _steady(self, at: JointFit, side: Candidate, lines: Sequence[Candidate]) -> bool:
        """True if a tone that does not decay explains more than the decaying one."""
        f, bin_hz = side.detail.frequency_hz or 0.0, 1.0 / float(at.started[0].time_s[-1])
        near = [c for c in lines if any(abs(g - f) < bin_hz for g in c.tones_hz)]
        return bool(near) and max(own_gain(at, c, self._pool).fall for c in near) >= own_gain(at, side, self._pool).fall

    def score_table(self, at: JointFit) -> ScoreTable:
        """Of everything that can be common to the shots and is not in a refit already."""
        taken = {c.key for c in at.hypothesis.effects}
        shared = [c for c in self._scan(at)[1] if c.shared]
        offered = [
            c for c in [*self._named, *transients(at), *shared]
            if c.key not in taken and not _same_effect_in(c, at)
        ]  # fmt: skip
        return score_table(at, offered, self._pool)

    def singles(self, seen: ScoreTable) -> tuple[CandidateTest, ...]:
        """Every candidate by itself, the most surprising first."""
        rows = []
        for block in seen.blocks:
            score = seen.gain([block])
            if score is not None:
                c = block.candidate
                log_p = log_chance(score.gain, c.size, self._trials * c.trials)
                rows.append(
                    CandidateTest(
                        (c,), tuple(score.strengths), tuple(score.sd), score.gain, log_p, step_allowed([block], score)
                    )
                )
        return tuple(sorted(rows, key=lambda t: (t.log_p, -t.gain)))

    def _best_common(self, seen: ScoreTable) -> float:
        """Logarithm of the chance of the most surprising candidate, of either sign, alone or with another."""
        floor = _NEGLIGIBLE * max(self._base.chi2 - seen.joint_fit.chi2, 0.0) / seen.joint_fit.noise_factor
        best = 0.0
        for sets, trials in ((singles(seen), 1.0), (pairs(seen), 0.5 * self._trials)):
            for blocks, score in sets:
                if score.gain > floor:
                    best = min(best, self._log_p(blocks, score, trials))
        return best

    def _log_p(self, blocks: Sequence[CandidateBlock], score: ScoreResult, more: float = 1.0) -> float:
        trials = self._trials * more
        for b in blocks:
            trials *= b.candidate.trials
        return log_chance(score.gain, sum(b.candidate.size for b in blocks), trials)

    def _best_own(self, at: JointFit) -> _Own | None:
        """The most surprising effect that every shot has for itself."""
        lines, sides = self._scan(at)
        offered = [*lines, *(c for c in sides if not c.shared)]
        floor = _NEGLIGIBLE * max(self._base.chi2 - at.chi2, 0.0)
        best: _Own | None = None
        for c in offered:
            if _same_effect_in(c, at):
                continue
            seen = own_gain(at, c, self._pool)
            if seen.fall > floor:
                trials = self._trials * c.trials
                log_p = log_chance(seen.gain, seen.columns, trials)
                if best is None or log_p < best.log_p:
                    best = _Own(c, log_p, log_chance(seen.fall / at.noise_factor, seen.columns, trials))
        return best

    def _grown(
        self, first: ScoreTable, seen: ScoreTable, best: JointFit, size: int
    ) -> tuple[JointFit | None, tuple[Candidate, ...]]:
        """The best refit with a set of this size; None if it is no better than what there is."""
        leaders = self._leaders(first, seen, size)
        fits = [f for f in (allowed_refit(h, start, self._pool) for h, start in leaders) if f is not None]
        fits.sort(key=lambda f: f.chi2 + _PER_SCALE * f.noise_factor * sum(len(c.hidden) for c in f.hypothesis.common))
        allowed = [f for f in fits if signs_allowed(f)]
        banned = tuple(c for c in fits[0].hypothesis.effects) if fits and not signs_allowed(fits[0]) else ()
        if not allowed:
            return None, banned
        fall = (best.chi2 - allowed[0].chi2) / allowed[0].noise_factor
        added = allowed[0].hypothesis.size - best.hypothesis.size
        new = [c for c in allowed[0].hypothesis.common if c.key not in {o.key for o in best.hypothesis.common}]
        sure = log_chance(fall, max(1, added), self._trials * math.prod(c.trials for c in new)) < LEVEL
        return (allowed[0], banned) if sure else (None, banned)

    def _leaders(self, first: ScoreTable, seen: ScoreTable, size: int) -> list[tuple[Hypothesis, JointFit]]:
        """Sets worth a refit: the best of this size beside the root, and the best additions to the present one."""
        sets = {1: singles, 2: pairs, 3: triples}[size](first)
        proposals = [(score.gain, first, blocks, score) for blocks, score in sets if step_allowed(blocks, score)]
        if size > 1:
            explained = (first.joint_fit.chi2 - seen.joint_fit.chi2) / seen.joint_fit.noise_factor
            proposals += [
                (explained + score.gain, seen, blocks, score)
                for blocks, score in singles(seen) if step_allowed(blocks, score)
            ]  # fmt: skip
        proposals.sort(key=lambda p: -p[0])
        chosen: list[tuple[Hypothesis, JointFit]] = []
        known: set[frozenset[object]] = set()
        for gain, at, blocks, _ in proposals:
            if (chosen and gain < (1.0 - _NEAR) * proposals[0][0] - _CLOSE) or len(chosen) >= _LEADERS:
                break
            hypothesis = at.joint_fit.hypothesis.plus(*(b.candidate for b in blocks))
            keys = frozenset(c.key for c in hypothesis.effects)
            if keys not in known:
                known.add(keys)
                chosen.append((hypothesis, at.joint_fit))
        return chosen


def _near_motion(c: Candidate, at: JointFit) -> bool:
    """So near the swing's own frequency that a torque which is not quite right looks the same."""
    f = c.detail.frequency_hz or 0.0
    motions = [s.dynamics for s in at.states]
    zones = [Zones.of_sweep(d.w, d.amplitude, relative=_BESIDE_MOTION, margin_hz=0.0) for d in motions]
    return any(z.low_hz < f < z.high_hz for z in zones)


def _same_effect_in(candidate: Candidate, at: JointFit) -> bool:
    """True if a hidden scale or a place of the same effect is in the refit already."""
    for c in at.hypothesis.effects:
        if c.effect is not candidate.effect:
            continue
        if c.hidden or candidate.hidden or (c.detail.tau_s is not None and c.detail.frequency_hz is None):
            return True
        if c.detail.frequency_hz and candidate.detail.frequency_hz:
            near = abs(c.detail.frequency_hz - candidate.detail.frequency_hz)
            return near < 3.0 / float(at.started[0].time_s[-1])
    return False

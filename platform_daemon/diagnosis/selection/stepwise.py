"""Stepwise selection: score tests of all candidates, refits of the best sets.

Effects are added until nothing significant is left, or nothing helps any more. Two effects that act together can hide
behind a third that mimics their sum; therefore sets of every size are drawn from the first score table too, not only by
adding to the best smaller set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

from platform_daemon.diagnosis.effects.additive import SIDE_MODE
from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.score_test import CandidateBlock, ScoreResult, ScoreTable, score_table
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.screening.spectral_lines import Zones

from .component_search import shot_residuals, side_modes, steady_tones, tones, transients
from .omnibus_test import OmnibusTest, omnibus_test
from .refits import allowed_refit, own_gain, refined, refined_own, refit
from .scales import at_best_scales
from .sign_constraints import signs_allowed, step_allowed
from .significance import LEVEL, log_chance
from .subsets import pairs, singles, triples

_LIMITS = THRESHOLDS.selection


ProgressCallback = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True)
class CandidateTest:
    """A candidate set with its evidence."""

    candidates: tuple[Candidate, ...]
    strengths: tuple[float, ...]
    sd: tuple[float, ...]
    gain: float
    log_p: float
    allowed: bool


@dataclass(frozen=True, kw_only=True)
class Selection:
    """The end of a search.

    Attributes:
        base: the joint fit of the declared model.
        best: the joint fit with everything that was accepted.
        score_table: of all other candidates, given it.
        omnibus_test: of its residual.
        before: the same given the declared model.
        tried: single candidates given the declared model, best first.
        trials: number of candidates, by which chances are corrected.
        score_table_of: all candidates given another refit.
        forbidden: the best set fits only with a sign that physics does not allow.
        rejected: a set that fits far better, but does not predict what was not used.
        torques: of an angle, the best set of torques; others: sets that leave hardly more, where that is no noise.
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
    rejected: JointFit | None = None
    torques: JointFit | None = None
    others: tuple[JointFit, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _PerShotEffect:
    """An effect that every shot has for itself, and the logarithm of its chance.

    Attributes:
        log_p: by the noise of the residual after it. log_p_before: by that before it, as for common effects.
    """

    candidate: Candidate
    log_p: float
    log_p_before: float


class StepwiseSearch:
    """State of a search."""

    def __init__(
        self,
        base: JointFit,
        named: list[Candidate],
        pool: Executor,
        progress: ProgressCallback,
        explained: JointFit | None = None,
        on_larger_sets: Callable[[], None] = lambda: None,
    ) -> None:
        """explained: what is so does not make the gains of torques negligible; None: nothing is yet, as in `base`.

        on_larger_sets: called once single effects do not suffice.
        """
        self._base = base
        self._explained = explained or base
        self._named = named
        self._pool = pool
        self._progress, self._on_larger_sets = progress, on_larger_sets
        self._trials = float(len(named) + len(transients(base)) + _LIMITS.unnamed_trials)
        self._scanned: tuple[JointFit, tuple[list[Candidate], list[Candidate]]] | None = None

    def run(self, start: JointFit) -> Selection:
        """Alternate between effects of each shot's own and sets of common ones, from a first fit on."""
        before = omnibus_test(self._base, self._pool)
        self._progress("scores of all candidates", 0.25)
        root, best = start, start
        first = table = self.score_table(root)
        tried = self.singles(first)
        forbidden: tuple[Candidate, ...] = ()
        size = additive = 0
        while True:
            own = self._best_own(best) if additive < _LIMITS.most_additive else None
            common = self._best_common(table)
            if own is not None and own.log_p < LEVEL and (common >= LEVEL or own.log_p_before < common):
                # Additive effects come first: the search for sets restarts with them in the model.
                sharp = refined_own(best, own.candidate, self._pool)
                root = refit(root.hypothesis.plus(sharp), root, self._pool) or root
                best = refit(best.hypothesis.plus(sharp), best, self._pool) or best
                first = self.score_table(root)
                table = first if size == 0 else self.score_table(best)
                additive += 1
                continue
            if common >= LEVEL or size == _LIMITS.largest_set:
                break
            size += 1
            if size > 1:
                self._on_larger_sets()
            self._progress(f"refits of sets of {size}", 0.3 + 0.15 * size)
            better, banned = self._grown(first, table, best, size)
            if better is None:
                # Two effects can hide from every single one: larger sets are tried all the same.
                forbidden = banned or forbidden
                continue
            better, forbidden = at_best_scales(refined(better, self._pool), self._pool), ()
            best, table = better, self.score_table(better)
        after = omnibus_test(best, self._pool) if best is not self._base else before
        return Selection(
            base=self._base,
            best=best,
            score_table=table,
            omnibus_test=after,
            before=before,
            tried=tried,
            trials=self._trials,
            score_table_of=self.score_table,
            forbidden=forbidden,
        )

    def _scan(self, at: JointFit) -> tuple[list[Candidate], list[Candidate]]:
        """(tones, side modes) in the residual of a refit; cached."""
        if self._scanned is None or self._scanned[0] is not at:
            left = shot_residuals(at, self._pool)
            sides = side_modes(at, left)
            lines = [*tones(at, left), *steady_tones(at, sides)]
            sides = [c for c in sides if not self._steady(at, c, lines)]
            if at.prepared[0].shot.record.quantity == "angle":
                lines, sides = ([c for c in some if not _near_motion(c, at)] for some in (lines, sides))
            self._scanned = at, (lines, sides)
        return self._scanned[1]

    def _steady(self, at: JointFit, side: Candidate, lines: Sequence[Candidate]) -> bool:
        """True if a tone that does not decay explains more than the decaying one."""
        f, bin_hz = side.detail.frequency_hz or 0.0, 1.0 / float(at.prepared[0].time_s[-1])
        near = [c for c in lines if any(abs(g - f) < bin_hz for g in c.tones_hz)]
        return bool(near) and max(own_gain(at, c, self._pool).fall for c in near) >= own_gain(at, side, self._pool).fall

    def score_table(self, at: JointFit) -> ScoreTable:
        """Of everything that can be common to the shots and is not in a refit already."""
        taken = {c.key for c in at.hypothesis.effects}
        own = at.hypothesis.model.terms  # torques among them, where every shot has its own strength
        shared = [c for c in self._scan(at)[1] if c.shared]
        offered = [
            c
            for c in [*self._named, *transients(at), *shared]
            if c.key not in taken and c.term not in own and not _same_effect_in(c, at)
        ]
        return score_table(at, offered, self._pool)

    def singles(self, table: ScoreTable) -> tuple[CandidateTest, ...]:
        """Every candidate by itself, the most surprising first."""
        rows = []
        for block in table.blocks:
            score = table.gain([block])
            if score is not None:
                c = block.candidate
                log_p = log_chance(score.gain, c.size, self._trials * c.trials)
                rows.append(
                    CandidateTest(
                        candidates=(c,),
                        strengths=tuple(score.strengths),
                        sd=tuple(score.sd),
                        gain=score.gain,
                        log_p=log_p,
                        allowed=step_allowed([block], score),
                    )
                )
        return tuple(sorted(rows, key=lambda t: (t.log_p, -t.gain)))

    def _best_common(self, table: ScoreTable) -> float:
        """Logarithm of the chance of the most surprising candidate, of either sign, alone or with another."""
        floor = self._negligible(table.joint_fit) / table.joint_fit.noise_factor
        best = 0.0
        for sets, trials in ((singles(table), 1.0), (pairs(table), 0.5 * self._trials)):
            for blocks, score in sets:
                if score.gain > floor:
                    best = min(best, self._log_p(blocks, score, trials))
        return best

    def _negligible(self, at: JointFit) -> float:
        """Fall of chi^2 that may be digits of what is explained: of a dipole none, while noise is not all that is left.

        The model of a pendulum is never whole, and small effects beside large ones then mend it.
        """
        whole = at.prepared[0].shot.record.quantity != "angle"
        if whole and at.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof:
            return 0.0
        return _LIMITS.negligible_share * max(self._explained.chi2 - at.chi2, 0.0)

    def _log_p(self, blocks: Sequence[CandidateBlock], score: ScoreResult, more: float = 1.0) -> float:
        trials = self._trials * more
        for b in blocks:
            trials *= b.candidate.trials
        return log_chance(score.gain, sum(b.candidate.size for b in blocks), trials)

    def _best_own(self, at: JointFit) -> _PerShotEffect | None:
        """The most surprising effect that every shot has for itself."""
        lines, sides = self._scan(at)
        offered = [*lines, *(c for c in sides if not c.shared)]
        floor = _LIMITS.negligible_share * max(self._base.chi2 - at.chi2, 0.0)
        quiet = at.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof
        best: _PerShotEffect | None = None
        for c in offered:
            if _same_effect_in(c, at):
                continue
            gain = own_gain(at, c, self._pool)
            # A line outside the sweeps of the harmonics is no digit of a motion that is followed down to the noise;
            # within the width of an oscillation that was found, it may be one of that, whose place is not exact yet.
            if gain.fall > floor or (c.tones_hz and quiet and not in_an_oscillation(c, at)):
                trials = self._trials * c.trials
                log_p = log_chance(gain.gain, gain.columns, trials)
                if best is None or log_p < best.log_p:
                    best = _PerShotEffect(
                        candidate=c,
                        log_p=log_p,
                        log_p_before=log_chance(gain.fall / at.noise_factor, gain.columns, trials),
                    )
        return best

    def _grown(
        self, first: ScoreTable, table: ScoreTable, best: JointFit, size: int
    ) -> tuple[JointFit | None, tuple[Candidate, ...]]:
        """The best refit with a set of this size; None if it is no better than what there is."""
        better: JointFit | None = None
        least = math.inf
        banned = tuple[Candidate, ...]()  # effects of the fit that leaves least, if its signs are not allowed
        for hypothesis, start in self._leaders(first, table, size):  # one at a time: a fit of many shots is large
            fit = allowed_refit(hypothesis, start, self._pool)
            if fit is None:
                continue
            allowed = signs_allowed(fit)
            if _compared_chi2(fit) < least:
                least, banned = _compared_chi2(fit), () if allowed else tuple(fit.hypothesis.effects)
            if allowed and (better is None or _compared_chi2(fit) < _compared_chi2(better)):
                better = fit
            del fit  # before the next one
        if better is None:
            return None, banned
        fall = (best.chi2 - better.chi2) / better.noise_factor
        added = better.hypothesis.size - best.hypothesis.size
        new = [c for c in better.hypothesis.common if c.key not in {o.key for o in best.hypothesis.common}]
        sure = log_chance(fall, max(1, added), self._trials * math.prod(c.trials for c in new)) < LEVEL
        return (better, banned) if sure else (None, banned)

    def _leaders(self, first: ScoreTable, table: ScoreTable, size: int) -> list[tuple[Hypothesis, JointFit]]:
        """Sets worth a refit: the best of this size given the root, and the best additions to the present one."""
        sets = {1: singles, 2: pairs, 3: triples}[size](first)
        proposals = [(score.gain, first, blocks, score) for blocks, score in sets if step_allowed(blocks, score)]
        if size > 1:
            explained = (first.joint_fit.chi2 - table.joint_fit.chi2) / table.joint_fit.noise_factor
            proposals += [
                (explained + score.gain, table, blocks, score)
                for blocks, score in singles(table)
                if step_allowed(blocks, score)
            ]
        proposals.sort(key=lambda p: -p[0])
        chosen: list[tuple[Hypothesis, JointFit]] = []
        known: set[frozenset[object]] = set()
        for gain, at, blocks, _ in proposals:
            if (chosen and gain < (1.0 - _LIMITS.overtaking_share) * proposals[0][0] - _LIMITS.overtaking_chi2) or len(
                chosen
            ) >= _LIMITS.leading_sets:
                break
            hypothesis = at.joint_fit.hypothesis.plus(*(b.candidate for b in blocks))
            keys = frozenset(c.key for c in hypothesis.effects)
            if keys not in known:
                known.add(keys)
                chosen.append((hypothesis, at.joint_fit))
        return chosen


def _compared_chi2(fit: JointFit) -> float:
    """chi^2 by which sets of effects are compared: each hidden scale costs some."""
    return fit.chi2 + _LIMITS.chi2_per_scale * fit.noise_factor * sum(bool(c.hidden) for c in fit.hypothesis.common)


def _near_motion(c: Candidate, at: JointFit) -> bool:
    """True if the frequency is so near that of the swing that a slightly wrong torque looks the same."""
    f = c.detail.frequency_hz or 0.0
    motions = [s.dynamics for s in at.states]
    zones = [Zones.of_sweep(d.w, d.amplitude, relative=_LIMITS.near_motion_share, margin_hz=0.0) for d in motions]
    return any(z.low_hz < f < z.high_hz for z in zones)


def in_an_oscillation(line: Candidate, at: JointFit) -> bool:
    """True if a line stands within the width of a decaying oscillation that the refit has."""
    seconds = float(at.prepared[0].time_s[-1])
    return any(
        abs(c.detail.frequency_hz - f) < _LIMITS.same_place_bins / min(c.detail.tau_s or seconds, seconds)
        for c in at.hypothesis.effects
        if c.effect is SIDE_MODE and c.detail.frequency_hz is not None
        for f in line.tones_hz
    )


def _same_effect_in(candidate: Candidate, at: JointFit) -> bool:
    """True if a hidden scale or a place of the same effect is in the refit already."""
    for c in at.hypothesis.effects:
        if c.effect is not candidate.effect:
            continue
        if c.hidden or candidate.hidden or (c.detail.tau_s is not None and c.detail.frequency_hz is None):
            return True
        if c.detail.frequency_hz and candidate.detail.frequency_hz:
            near = abs(c.detail.frequency_hz - candidate.detail.frequency_hz)
            return near < _LIMITS.same_place_bins / float(at.prepared[0].time_s[-1])
    return False

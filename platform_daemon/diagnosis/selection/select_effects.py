"""All effects of a set of shots: of angles torques first, then what acts beside them, then torques again.

Where a line or a second mode stands in the residual, its samples are so much alike that no torque is sure; and where a
torque is missing, no line is. Each is therefore judged beside the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import numpy as np

from platform_daemon.diagnosis.effects.additive import OSCILLATIONS
from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.cross_validation import cross_validate
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly
from platform_daemon.diagnosis.regression.prediction import unpredicted
from platform_daemon.diagnosis.shots.shot import PreparedShot, as_measured, whitening_for
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.model import OWN_RESIDUAL
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.screening.spectral_lines import periodogram

from .refits import lines_in_place, refit
from .stepwise import ProgressCallback, Selection, StepwiseSearch
from .torque_sets import TorqueSearch, best_torques

_LIMITS = THRESHOLDS.selection


def select_effects(
    base: JointFit,
    candidates: Sequence[Candidate],
    pool: Executor,
    progress: ProgressCallback,
    on_larger_sets: Callable[[], None] = lambda: None,
) -> Selection:
    """Add effects to the declared model until nothing that has a name is left.

    candidates: torque and receiver candidates; additive ones are searched for here.
    on_larger_sets: called once single effects of a dipole do not suffice.

    Raises:
        LostTrajectoryError: the declared model itself describes no oscillation.
    """
    angle = base.prepared[0].shot.record.quantity == "angle"
    if not angle or base.leaves_noise:
        found = StepwiseSearch(base, list(candidates), pool, progress, on_larger_sets=on_larger_sets).run(base)
        quieter = _at_its_own_noise(base, found.best, pool) if angle else None
        if quieter is None:
            return found
        base = quieter
        if base.leaves_noise:
            return StepwiseSearch(base, list(candidates), pool, progress).run(base)
    sets, beside = _AngleSearch(base, candidates, pool, progress).run()
    quieter = _at_its_own_noise(base, beside.best, pool) if beside.best.leaves_noise else None
    if quieter is not None:
        with suppress(LostTrajectoryError, np.linalg.LinAlgError):
            again = _AngleSearch(quieter, candidates, pool, progress).run(_oscillations(beside.best))
            base, (sets, beside) = quieter, again
    every = StepwiseSearch(base, list(candidates), pool, progress)
    return replace(
        beside,
        tried=every.singles(every.score_table(base)),
        score_table=every.score_table(beside.best),
        score_table_of=every.score_table,
        rejected=sets.rejected,
        torques=sets.best,
        others=sets.others,
    )


def _at_its_own_noise(base: JointFit, best: JointFit, pool: Executor) -> JointFit | None:
    """The fit of the declared model with the noise that another fit leaves; None where that is no smaller.

    What looked like noise beside the swing was a part of it, or a line.
    """
    quiet = _as_quiet_as(best)
    try:
        return None if quiet is None else fit_jointly(quiet, base.hypothesis, pool, base.states)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def _as_quiet_as(best: JointFit) -> list[PreparedShot] | None:
    """The shots with noise of the level that a fit leaves above the swing and its harmonics.

    None where that is not much below what was taken for noise, or where it is not flat, as of an angle that was
    filtered.
    """
    out, quieter = [], False
    for k, prepared in enumerate(best.prepared):
        level = flat_level(unpredicted(best, k), prepared.state.dynamics.w / (2.0 * math.pi * prepared.shot.rate_hz))
        share = math.inf if level is None else level / float(prepared.shot.noise.sd[0])
        if share > _LIMITS.quieter_share:
            out.append(prepared)
            continue
        shot = as_measured(replace(prepared.shot, noise=prepared.shot.noise.at_level(share, OWN_RESIDUAL)))
        quieter |= bool(shot.noise.sd[0] < _LIMITS.quieter_share * prepared.shot.noise.sd[0])
        white = whitening_for(shot, prepared.grids, prepared.state.dynamics.w / (2.0 * math.pi))
        out.append(replace(prepared, shot=shot, white=white))
    return out if quieter else None


def flat_level(left: Array, cycles: float) -> float | None:
    """Standard deviation of white samples with the noise that stands in what is left (1, n) of an angle.

    None where the upper three quarters of the band are not flat.  Of an encoder that is read more often than it counts,
    the quantisation is slow and repeats with the swing: flat far up, louder near the swing, where effects are judged,
    and in lines there if the frequency hardly moves.  The octave above the harmonics that a fit compares therefore
    counts where it is louder, by its mean power.  A line that is no part of this is at one harmonic only: the loudest
    one does not count.

    cycles: of the swing per sample.
    """
    power = periodogram(left, np.hanning(left.shape[1]), left.shape[1])[0]
    upper = np.array_split(power, 4)[1:]
    second, _, fourth = (float(np.median(part)) for part in upper)
    if max(second, fourth) > _LIMITS.flat_ratio * min(second, fourth):
        return None
    level = float(np.median(np.concatenate(upper))) / math.log(2.0)
    lowest = THRESHOLDS.shots.pass_band
    edges = np.round(np.arange(lowest, 2.0 * lowest + 1.0) * cycles * left.shape[1]).astype(int)
    if edges[-1] <= power.size and edges[1] > edges[0]:
        *others, _ = sorted(float(np.mean(power[a:b])) for a, b in pairwise(edges))
        level = max(level, float(np.mean(others)))
    return math.sqrt(level)


class _AngleSearch:
    """Torques and oscillations in turn."""

    def __init__(
        self, base: JointFit, candidates: Sequence[Candidate], pool: Executor, progress: ProgressCallback
    ) -> None:
        self._base = base
        self._candidates = candidates
        self._pool = pool
        self._progress = progress
        self._judged_beside = 0  # oscillations, when torques were judged last

    def run(self, lines: Sequence[Candidate] = ()) -> tuple[TorqueSearch, Selection]:
        """The last search of sets of torques, and everything that was found; lines: that are known beforehand."""
        known = refit(self._base.hypothesis.plus(*lines), self._base, self._pool) if lines else None
        sets = self._torques(known or self._base)
        beside = self._beside(sets.best, known)
        for _ in range(_LIMITS.torque_rounds):
            again = self._again(sets, beside)
            if again is None:
                break
            sets, beside = again
        return sets, beside

    def _torques(self, at: JointFit) -> TorqueSearch:
        return best_torques(at, self._candidates, float(len(self._candidates)), self._pool, self._progress)

    def _beside(self, torques: JointFit, explained: JointFit | None = None) -> Selection:
        """What acts beside a set of torques; where little is left, torques too, for linear scores are right there."""
        offered = [c for c in self._candidates if (c.term is None and c.change is None) or torques.leaves_noise]
        return StepwiseSearch(self._base, offered, self._pool, self._progress, explained).run(torques)

    def _again(self, sets: TorqueSearch, found: Selection) -> tuple[TorqueSearch, Selection] | None:
        """The torques judged again beside oscillations, and these put in their places beside the torques.

        None where this explains no more.
        """
        start = self._with_oscillations(sets, found.best)
        if start is None or len(_oscillations(start)) == self._judged_beside:
            return None
        start = lines_in_place(start, self._pool)
        lines = _oscillations(start)
        known = refit(self._base.hypothesis.plus(*lines), start, self._pool)
        if known is None:
            return None
        self._judged_beside = len(lines)
        if known.leaves_noise:
            more = self._beside(start, known)
            more = replace(more, best=lines_in_place(more.best, self._pool))
            return (sets, more) if self._better(more.best, found.best) else None
        again = self._torques(known)
        best = lines_in_place(again.best, self._pool)
        if best.chi2 < start.chi2 and self._better(best, found.best):
            return replace(again, best=best), self._beside(best, known)
        return (sets, self._beside(start, known)) if self._better(start, found.best) else None

    def _with_oscillations(self, sets: TorqueSearch, best: JointFit) -> JointFit | None:
        """The best fit if it has any; else those that are sure beside the next set of torques, which was not."""
        if _oscillations(best):
            return best
        if best.leaves_noise or sets.next_larger is None:
            return None
        beside = self._beside(sets.next_larger).best
        return beside if _oscillations(beside) else None

    def _better(self, one: JointFit, other: JointFit) -> bool:
        """With the same effects by chi^2; with others by the prediction, where more than noise is left by a tenth."""
        if one.chi2 > other.chi2 - _LIMITS.place_move_chi2 * one.noise_factor:
            return False
        if _effects(one) == _effects(other):
            return True
        scores = [cross_validate(at, self._pool) for at in (one, other)]
        if one.leaves_noise:
            return scores[1].worse_by(scores[0]) > 0.0
        return scores[0].total.nrmse < _LIMITS.helping_ratio * scores[1].total.nrmse


def _oscillations(at: JointFit) -> list[Candidate]:
    return [c for c in at.hypothesis.effects if c.effect in OSCILLATIONS]


def _effects(at: JointFit) -> list[str]:
    return sorted(c.effect.id for c in at.hypothesis.effects)

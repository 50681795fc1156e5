"""Effects that cannot be told apart on these data: what could stand in the place of an accepted one."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation import LostTrajectoryError

from ..effects.effect import Candidate, Effect
from ..regression.hypothesis import Hypothesis
from ..regression.information import solved
from ..regression.joint_fit import JointFit, fit_jointly, starting_point
from ..regression.score_test import CandidateBlock, ScoreTable
from .refits import allowed_refit
from .sign_constraints import signs_allowed, without_gain_of_energy

TOLD_APART = 10.8  # rise of chi^2: 3.3 standard deviations
_WORTH_A_REFIT = 60.0  # rise by the linear step that a refit may still bring down
_SHARE = 0.05  # of the effect's own gain, the same
_MOST_REFITS = 10
_NEAR_MISSES, _SECONDS = 2, 3  # torques that nearly take the place, and what is tried beside each
_BETTER = 3.84  # fall of chi^2 that a second effect brings by chance in one case of 20


@dataclass(frozen=True)
class Confounder:
    """An alternative for an accepted effect.

    rise: of chi^2 if it takes the effect's place; negative: it fits better. gain: what the effect itself gains.
    beside: a second effect that takes the place with it, None: it does so alone.
    """

    candidate: Candidate
    rise: float
    gain: float
    joint_fit: JointFit | None = None
    beside: Candidate | None = None

    @property
    def indistinguishable(self) -> bool:
        """Not told apart with any confidence."""
        return self.rise < TOLD_APART


def confounders(seen: ScoreTable, effect: Candidate, pool: Executor) -> list[Confounder]:
    """Alternatives for one common effect of the score table's fit, the best first; found once."""
    if effect.key not in seen.alternatives:
        seen.alternatives[effect.key] = _confounders(seen, effect, pool)
    return list(seen.alternatives[effect.key])


def _confounders(seen: ScoreTable, effect: Candidate, pool: Executor) -> list[Confounder]:
    at = seen.joint_fit
    gain = gain_of(at, effect)
    found = []
    for block in seen.blocks:
        rise = _exchange(seen, effect, [block])
        if rise is not None and rise < _WORTH_A_REFIT + _SHARE * gain:
            found.append(Confounder(block.candidate, rise, gain))
    found.sort(key=lambda r: r.rise)
    checked = [_checked(at, effect, r, pool) for r in found[:_MOST_REFITS]]
    return sorted((r for r in checked if r is not None), key=lambda r: r.rise)


def two_in_place(seen: ScoreTable, effect: Candidate, alone: Sequence[Confounder], pool: Executor) -> list[Confounder]:
    """Torques that nearly take a torque's place, and with a second one do so better than it does.

    One effect is the simpler explanation and stays the name as long as two are not surely better; that they may be
    there has to be said. alone: what takes the place alone, the best first.
    """
    found: list[Confounder] = []
    alike = {r.candidate.effect for r in alone if r.indistinguishable}  # these need no second one
    near = [r for r in alone if r.candidate.term is not None and not r.indistinguishable and r.joint_fit is not None]
    for rival in near[:_NEAR_MISSES] if effect.term is not None else []:
        assert rival.joint_fit is not None
        first = next(b for b in seen.blocks if b.candidate is rival.candidate)
        beside = [
            (_exchange(seen, effect, [first, b]), b.candidate)
            for b in seen.blocks
            if _second(b, {*alike, rival.candidate.effect})
        ]
        seconds = sorted(((rise, c) for rise, c in beside if rise is not None), key=lambda pair: pair[0])
        for _, second in seconds[:_SECONDS]:
            if any(r.beside is not None and r.candidate.effect is second.effect for r in found):
                continue  # the same two, the other way round
            both = allowed_refit(rival.joint_fit.hypothesis.plus(second), rival.joint_fit, pool)
            rise = math.inf if both is None else (both.chi2 - seen.joint_fit.chi2) / both.noise_factor
            if both is not None and rise < -_BETTER and signs_allowed(both):
                found.append(Confounder(rival.candidate, rise, rival.gain, both, second))
    return found


def _second(block: CandidateBlock, others: Container[Effect]) -> bool:
    """A torque of one strength that another may stand beside; those that depend on time take too long."""
    c = block.candidate
    return c.term is not None and not c.term.timed and not c.hidden and c.effect not in others


def _place(at: JointFit, effect: Candidate) -> slice:
    """Where its strengths stand."""
    return next(s for c, s in zip(at.hypothesis.common, at.hypothesis.slices, strict=True) if c.key == effect.key)


def gain_of(at: JointFit, effect: Candidate) -> float:
    """Rise of chi^2 over the noise factor if an accepted effect is left out, to first order; 0 for a shot's own."""
    if effect not in at.hypothesis.common:
        return 0.0
    where = _place(at, effect)
    value = at.strengths[where]
    return float(value @ np.linalg.lstsq(at.covariance[where, where], value, rcond=None)[0]) / at.noise_factor


def _exchange(seen: ScoreTable, effect: Candidate, blocks: Sequence[CandidateBlock]) -> float | None:
    """Rise of chi^2 if blocks take the effect's place, to first order; None if they are not seen beside the rest."""
    at = seen.joint_fit
    gone = range(*_place(at, effect).indices(seen.accepted))
    kept = [k for k in range(seen.accepted) if k not in gone]
    new = [k for b in blocks for k in b.where]
    which = [*kept, *new]
    if not np.all(np.diag(seen.information)[new] > 1e-11 * seen.power[new]):
        return None
    # Without the effect's part the residual is turned by what it explained.
    removed = seen.information[:, list(gone)] @ at.strengths[list(gone)]
    gradient = (seen.gradient + removed)[which]
    matrix = seen.information[np.ix_(which, which)]
    explained = float(gradient @ solved(matrix, gradient))
    value = at.strengths[list(gone)]
    whole = float(value @ seen.information[np.ix_(list(gone), list(gone))] @ value)
    whole += 2.0 * float(value @ seen.gradient[list(gone)])
    return (whole - explained) / at.noise_factor


def _checked(at: JointFit, effect: Candidate, rival: Confounder, pool: Executor) -> Confounder | None:
    """The same by a refit."""
    hypothesis: Hypothesis = at.hypothesis.without(next(c for c in at.hypothesis.effects if c.key == effect.key)).plus(
        rival.candidate
    )
    try:
        worth = at.chi2 + TOLD_APART * at.noise_factor
        found = fit_jointly(at.started, hypothesis, pool, *starting_point(at, hypothesis), worth)
        if found.chi2 - at.chi2 > max(rival.gain, TOLD_APART) * at.noise_factor:
            # Nothing is worse than nothing in the effect's place: the way down leads from the shots' own fits.
            found = fit_jointly(at.started, hypothesis, pool, worth=worth)
        found = without_gain_of_energy(found, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    if not signs_allowed(found):
        return None
    return Confounder(rival.candidate, (found.chi2 - at.chi2) / at.noise_factor, rival.gain, found)

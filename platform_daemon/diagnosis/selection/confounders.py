"""Effects that these data cannot distinguish from an accepted one."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate, Effect
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.information import solved
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly, starting_point, starting_strengths
from platform_daemon.diagnosis.regression.score_test import CandidateBlock, ScoreTable
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .refits import allowed_refit
from .sign_constraints import signs_allowed, without_gain_of_energy

_LIMITS = THRESHOLDS.selection


@dataclass(frozen=True, kw_only=True)
class Confounder:
    """An alternative for an accepted effect.

    rise: of chi^2 if it takes the effect's place; negative: it fits better. gain: what the effect itself gains.
    second: a further effect that it needs to take the place, None if it needs none.
    """

    candidate: Candidate
    rise: float
    gain: float
    joint_fit: JointFit | None = None
    second: Candidate | None = None

    @property
    def indistinguishable(self) -> bool:
        """True if the data do not exclude it."""
        return self.rise < _LIMITS.told_apart_chi2


def confounders(table: ScoreTable, effect: Candidate, pool: Executor) -> list[Confounder]:
    """Alternatives for one common effect of the score table's fit, the best first; found once."""
    if effect.key not in table.alternatives:
        table.alternatives[effect.key] = _confounders(table, effect, pool)
    return list(table.alternatives[effect.key])


def _confounders(table: ScoreTable, effect: Candidate, pool: Executor) -> list[Confounder]:
    at = table.joint_fit
    gain = gain_of(at, effect)
    found = list[tuple[Confounder, Array]]()
    for block in table.blocks:
        exchanged = _exchange(table, effect, [block])
        if exchanged is not None and exchanged[0] < _LIMITS.refit_chi2 + _LIMITS.refit_share * gain:
            found.append((Confounder(candidate=block.candidate, rise=exchanged[0], gain=gain), exchanged[1]))
    found.sort(key=lambda pair: pair[0].rise)
    checked = [_checked(at, effect, *pair, pool) for pair in found[: _LIMITS.most_refits]]
    return sorted((r for r in checked if r is not None), key=lambda r: r.rise)


def two_in_place(table: ScoreTable, effect: Candidate, alone: Sequence[Confounder], pool: Executor) -> list[Confounder]:
    """Torques that nearly take a torque's place, and with a second one do so better than it does.

    One effect is the simpler explanation and stays the name while two are not significantly better; that they may be
    there is reported. alone: what takes the place alone, the best first.
    """
    found: list[Confounder] = []
    alike = {r.candidate.effect for r in alone if r.indistinguishable}  # these need no second one
    near = [r for r in alone if r.candidate.term is not None and not r.indistinguishable and r.joint_fit is not None]
    for rival in near[: _LIMITS.near_misses] if effect.term is not None else []:
        assert rival.joint_fit is not None
        first = next(b for b in table.blocks if b.candidate is rival.candidate)
        exchanged = [
            (_exchange(table, effect, [first, b]), b.candidate)
            for b in table.blocks
            if _second(b, {*alike, rival.candidate.effect})
        ]
        seconds = sorted(((found[0], c) for found, c in exchanged if found is not None), key=lambda pair: pair[0])
        for _, second in seconds[: _LIMITS.second_torques]:
            if any(r.second is not None and r.candidate.effect is second.effect for r in found):
                continue  # the same two, the other way round
            both = allowed_refit(rival.joint_fit.hypothesis.plus(second), rival.joint_fit, pool)
            rise = math.inf if both is None else (both.chi2 - table.joint_fit.chi2) / both.noise_factor
            if both is not None and rise < -_LIMITS.second_chi2 and signs_allowed(both):
                found.append(
                    Confounder(candidate=rival.candidate, rise=rise, gain=rival.gain, joint_fit=both, second=second)
                )
    return found


def _second(block: CandidateBlock, others: Container[Effect]) -> bool:
    """True for a torque that may be the second one; torques that depend on time take too long."""
    c = block.candidate
    return c.term is not None and not c.term.timed and not c.hidden and c.effect not in others


def _place(at: JointFit, effect: Candidate) -> slice:
    """Slice of its strengths."""
    return _slice_of(at.hypothesis, effect)


def _slice_of(hypothesis: Hypothesis, effect: Candidate) -> slice:
    return next(s for c, s in zip(hypothesis.common, hypothesis.slices, strict=True) if c.key == effect.key)


def gain_of(at: JointFit, effect: Candidate) -> float:
    """Rise of chi^2 over the noise factor if an accepted effect is left out, to first order; 0 for a shot's own."""
    if effect not in at.hypothesis.common:
        return 0.0
    where = _place(at, effect)
    value = at.strengths[where]
    return float(value @ np.linalg.lstsq(at.covariance[where, where], value, rcond=None)[0]) / at.noise_factor


def _exchange(table: ScoreTable, effect: Candidate, blocks: Sequence[CandidateBlock]) -> tuple[float, Array] | None:
    """Rise of chi^2 if blocks take the effect's place, and their strengths, to first order; None if the rest absorbs
    them."""
    at = table.joint_fit
    replaced = range(*_place(at, effect).indices(table.accepted))
    kept = [k for k in range(table.accepted) if k not in replaced]
    new = [k for b in blocks for k in b.where]
    which = [*kept, *new]
    if not np.all(np.diag(table.information)[new] > THRESHOLDS.regression.resolved_share * table.power[new]):
        return None
    # Without the effect's part the residual is turned by what it explained.
    removed = table.information[:, list(replaced)] @ at.strengths[list(replaced)]
    gradient = (table.gradient + removed)[which]
    matrix = table.information[np.ix_(which, which)]
    step = solved(matrix, gradient)
    explained = float(gradient @ step)
    value = at.strengths[list(replaced)]
    whole = float(value @ table.information[np.ix_(list(replaced), list(replaced))] @ value)
    whole += 2.0 * float(value @ table.gradient[list(replaced)])
    return (whole - explained) / at.noise_factor, step[len(kept) :]


def _checked(at: JointFit, effect: Candidate, rival: Confounder, strengths: Array, pool: Executor) -> Confounder | None:
    """The same by a refit; strengths: of the rival, to first order."""
    hypothesis: Hypothesis = at.hypothesis.without(next(c for c in at.hypothesis.effects if c.key == effect.key)).plus(
        rival.candidate
    )
    apart = _LIMITS.told_apart_chi2
    worth = at.chi2 + apart * at.noise_factor
    try:
        found = fit_jointly(at.prepared, hypothesis, pool, *starting_point(at, hypothesis), worth)
        if rival.rise < apart and found.chi2 > worth:
            # The course of a friction makes up for the missing effect before its rival has grown, and may lead astray.
            begun = starting_strengths(at, hypothesis)
            begun[_slice_of(hypothesis, rival.candidate)] = strengths
            with suppress(LostTrajectoryError, np.linalg.LinAlgError):
                again = fit_jointly(at.prepared, hypothesis, pool, at.states, begun, worth)
                found = min(found, again, key=lambda fit: fit.chi2)
        if found.chi2 - at.chi2 > max(rival.gain, apart) * at.noise_factor:
            # A fit worse than without any effect missed the minimum: it starts again from the shots' own fits.
            found = fit_jointly(at.prepared, hypothesis, pool, worth=worth)
        found = without_gain_of_energy(found, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    if not signs_allowed(found):
        return None
    return Confounder(
        candidate=rival.candidate,
        rise=(found.chi2 - at.chi2) / at.noise_factor,
        gain=rival.gain,
        joint_fit=found.without_processes(),
    )

"""Score tests of candidates given everything that is fitted.

Each shot's own parameters are projected out by orthogonal factorisation (the Gram matrix would lose the last digits,
on which look-alikes such as torsion stiffness depend). What is left of all shots adds up to one small matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.torque import SPRINGS
from platform_daemon.diagnosis.shots.linearisation import Linearisation, linearise_signal
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.torque_course import course_of
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .hypothesis import Hypothesis
from .information import solved
from .joint_fit import JointFit
from .start_changes import f_nat_column

_LIMITS = THRESHOLDS.regression


@dataclass(frozen=True)
class CandidateBlock:
    """A candidate and the indices of its columns in a score table."""

    candidate: Candidate
    where: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class ScoreTable:
    """All columns of all shots after projection: information (k, k), gradient (k,), full power (k,).

    The first `accepted` columns are the common strengths of the refit; blocks of candidates follow.
    alternatives: to accepted effects, by their keys, as `selection.confounders` has found them.
    """

    joint_fit: JointFit
    information: Array
    gradient: Array
    power: Array
    accepted: int
    blocks: tuple[CandidateBlock, ...]
    alternatives: dict[object, list[Any]] = field(default_factory=dict, compare=False, repr=False)

    def gain(self, blocks: Sequence[CandidateBlock]) -> ScoreResult | None:
        """Gain of a linear step in these blocks and the accepted strengths; None if the matrix is singular."""
        added = [k for b in blocks for k in b.where]
        which = [*range(self.accepted), *added]
        if not np.all(np.diag(self.information)[added] > _LIMITS.resolved_share * self.power[added]):
            return None
        return _score(
            self.information[np.ix_(which, which)], self.gradient[which], len(added), self.joint_fit.noise_factor
        )

    def schur_complement(self, which: list[int]) -> tuple[Array, Array]:
        """Information (k, k) and gradient (k,) of columns, accepted strengths eliminated; unresolved ones are 0."""
        q = self.accepted
        matrix, gradient = self.information[np.ix_(which, which)], self.gradient[which]
        if q:
            within = solved(self.information[:q, :q], self.information[:q][:, which])
            matrix = matrix - self.information[np.ix_(which, range(q))] @ within
            gradient = gradient - within.T @ self.gradient[:q]
        visible = np.diag(matrix) > _LIMITS.resolved_share * self.power[which]
        return np.where(np.outer(visible, visible), matrix, 0.0), np.where(visible, gradient, 0.0)


@dataclass(frozen=True, kw_only=True)
class ScoreResult:
    """A linear step: the new strengths (q,), their standard deviations (q,), the fall of chi^2 over the noise factor.

    steps: of everything, accepted strengths first.
    """

    strengths: Array
    sd: Array
    gain: float
    steps: Array

    def p_value(self, trials: float = 1.0) -> float:
        """p-value of the gain, corrected for the number of trials."""
        return float(min(1.0, trials * chi2_distribution.sf(self.gain, self.strengths.size)))


def _score(matrix: Array, gradient: Array, added: int, noise_factor: float) -> ScoreResult | None:
    """Joint score test; None if the matrix is singular."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    if values[0] < _LIMITS.told_apart_eigenvalue:
        return None
    covariance = (vectors / values) @ vectors.T * np.outer(scale, scale)
    steps = covariance @ gradient
    first = matrix.shape[0] - added
    sd = np.sqrt(np.diag(covariance)[first:] * noise_factor)
    return ScoreResult(strengths=steps[first:], sd=sd, gain=float(gradient @ steps) / noise_factor, steps=steps)


def score_table(at: JointFit, candidates: Sequence[Candidate], pool: Executor) -> ScoreTable:
    """Score table of candidates given a refit.

    Torque candidates are linearised in the refit's model with their terms at zero strength. Raises
    LostTrajectoryError.
    """
    accepted = at.hypothesis.size
    blocks, place = [], accepted
    for c in candidates:
        columns = tuple(range(place, place + c.size))
        place += c.size
        blocks.append(CandidateBlock(c, columns))
        each = c.size // max(1, len(c.parts))
        blocks += [CandidateBlock(p, columns[n * each : (n + 1) * each]) for n, p in enumerate(c.parts)]
    parts = list(pool.map(lambda k: _one(at, k, candidates), range(len(at.linear))))
    information, gradient, power = (sum(x[1:], start=x[0]) for x in zip(*parts, strict=True))
    return ScoreTable(
        joint_fit=at, information=information, gradient=gradient, power=power, accepted=accepted, blocks=tuple(blocks)
    )


def _one(at: JointFit, k: int, candidates: Sequence[Candidate]) -> tuple[Array, Array, Array]:
    """Information, gradient and power of one shot."""
    linear = at.linear[k]
    new = candidate_columns(at.prepared[k], at.hypothesis, at, k, candidates)
    return linear.projected(np.concatenate([linear.columns.T, new]))


def candidate_columns(
    prepared: PreparedShot, hypothesis: Hypothesis, at: JointFit, k: int, candidates: Sequence[Candidate]
) -> Array:
    """Columns of candidates in units of the noise, (sum of sizes, rows), in their order."""
    linear = at.linear[k]
    torque = _torque_columns(prepared, hypothesis, at, k, candidates)
    rows = []
    for c in candidates:
        if c.term is not None:
            rows.append(torque[c.key])
        else:
            assert c.columns is not None
            rows.append(linear.linearisation.white(c.columns(linear.linearisation)))
    return np.concatenate([np.empty((0, linear.linearisation.whitened.size)), *rows])


def _torque_columns(
    prepared: PreparedShot, hypothesis: Hypothesis, at: JointFit, k: int, candidates: Sequence[Candidate]
) -> dict[object, Array]:
    """Columns of the torque candidates by their keys, each (1, rows)."""
    torques = [c for c in candidates if c.term is not None]
    courses = [c for c in torques if c.f_nat_course is not None and _f_nat_is_free(hypothesis, at, k)]
    # Each value of a hidden scale needs its own linearisation, and so does each torque that depends on time.
    alone = [c for c in torques if c not in courses and (c.hidden or (c.term is not None and c.term.timed))]
    found: dict[object, Array] = {}
    for group in ([c for c in torques if c not in courses and c not in alone], *([c] for c in alone)):
        if group:
            try:
                wide, values, linearisation = _with_torques(prepared, hypothesis, at, k, group)
            except LostTrajectoryError:  # a torque of time beside a large kick: nothing tells its strength
                found |= {c.key: np.zeros((1, at.linear[k].residual.size)) for c in group}
                continue
            _, rows = wide.torque_rows(at.states[k], values, linearisation.base)
            found |= {c.key: row[None] for c, row in zip(wide.torques, rows, strict=True)}
    if courses:
        model, (_, _, linearisation) = hypothesis.augmented, _with_torques(prepared, hypothesis, at, k, [])
        for c in courses:
            assert c.f_nat_course is not None
            column = f_nat_column(linearisation, model, linearisation.state, c.f_nat_course)
            found[c.key] = linearisation.white(column)[None]
    return found


def _f_nat_is_free(hypothesis: Hypothesis, at: JointFit, k: int) -> bool:
    """True where the derivative by f_nat gives the response to its course: nothing else depends on it, or on time."""
    if course_of(at.states[k]) is not None:
        return False
    terms = hypothesis.augmented.terms
    return not hypothesis.augmented.time_dependent and not SPRINGS & {t.name for t in terms}


def _with_torques(
    prepared: PreparedShot, hypothesis: Hypothesis, at: JointFit, k: int, group: Sequence[Candidate]
) -> tuple[Hypothesis, Array, Linearisation]:
    """The hypothesis with further torques of strength 0, the strengths of its torques, and shot k linearised."""
    wide = hypothesis.plus(*group)
    order = [*hypothesis.torques, *group]
    values = np.zeros(len(wide.torques))
    for place, c in enumerate(wide.torques):
        values[place] = at.strengths[order.index(c)] if c in hypothesis.torques else 0.0
    strengths = np.concatenate([values, at.strengths[len(hypothesis.torques) :]])
    process, full = at.linear[k].linearisation.process, wide.extended(at.states[k], strengths)
    if process is None:
        return wide, values, wide.through(linearise_signal(prepared, wide.augmented, full), strengths)
    # Only the rows of the torques are used; the noise by the course is taken from the shot's own linearisation.
    linearisation = wide.received(linearise_signal(prepared, wide.augmented, full, frozen_course=True), strengths)
    return wide, values, replace(linearisation, process=process)

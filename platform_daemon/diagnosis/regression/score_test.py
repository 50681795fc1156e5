"""Score tests: how much of every candidate is visible beside what is fitted, and how much of it is in the residual.

Each shot's own parameters are projected out by orthogonal factorisation (the Gram matrix would lose the last digits,
on which look-alikes such as torsion stiffness depend). What is left of all shots adds up to one small matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from platform_daemon.estimation import Array

from ..effects.effect import Candidate
from ..effects.torque import SPRINGS
from ..shots.linearisation import Linearisation, linearise_signal
from ..shots.shot import PreparedShot
from .hypothesis import Hypothesis
from .information import solved
from .joint_fit import JointFit
from .start_changes import f_nat_column

_RESOLVED = 1e-11  # part of a column's power that must survive the projection
_SINGULAR = 1e-9  # smallest eigenvalue of a scaled matrix that still tells candidates apart


@dataclass(frozen=True)
class CandidateBlock:
    """Columns of one candidate in a score table: whose they are, and where they stand."""

    candidate: Candidate
    where: tuple[int, ...]


@dataclass(frozen=True)
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
        """What linear steps in these blocks, and in what is accepted, would gain; None if they cannot be told apart."""
        added = [k for b in blocks for k in b.where]
        which = [*range(self.accepted), *added]
        if not np.all(np.diag(self.information)[added] > _RESOLVED * self.power[added]):
            return None
        return _score(
            self.information[np.ix_(which, which)], self.gradient[which], len(added), self.joint_fit.noise_factor
        )

    def beside_accepted(self, which: list[int]) -> tuple[Array, Array]:
        """Information (k, k) and gradient (k,) of some columns beside the accepted strengths; invisible ones are 0."""
        q = self.accepted
        matrix, gradient = self.information[np.ix_(which, which)], self.gradient[which]
        if q:
            within = solved(self.information[:q, :q], self.information[:q][:, which])
            matrix = matrix - self.information[np.ix_(which, range(q))] @ within
            gradient = gradient - within.T @ self.gradient[:q]
        seen = np.diag(matrix) > _RESOLVED * self.power[which]
        return np.where(np.outer(seen, seen), matrix, 0.0), np.where(seen, gradient, 0.0)


@dataclass(frozen=True)
class ScoreResult:
    """A linear step: the new strengths (q,), their standard deviations (q,), the fall of chi^2 over the noise factor.

    steps: of everything, accepted strengths first.
    """

    strengths: Array
    sd: Array
    gain: float
    steps: Array

    def p_value(self, trials: float = 1.0) -> float:
        """Chance of such a gain anywhere in so many trials if the strengths are zero."""
        return float(min(1.0, trials * chi2_distribution.sf(self.gain, self.strengths.size)))


def _score(matrix: Array, gradient: Array, added: int, noise_factor: float) -> ScoreResult | None:
    """Joint score test; None if the matrix is singular."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    if values[0] < _SINGULAR:
        return None
    covariance = (vectors / values) @ vectors.T * np.outer(scale, scale)
    steps = covariance @ gradient
    first = matrix.shape[0] - added
    sd = np.sqrt(np.diag(covariance)[first:] * noise_factor)
    return ScoreResult(steps[first:], sd, float(gradient @ steps) / noise_factor, steps)


def score_table(at: JointFit, candidates: Sequence[Candidate], pool: Executor) -> ScoreTable:
    """Columns of candidates beside a refit.

    Torque candidates are seen through the refit's model with their terms at zero strength. Raises
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
    return ScoreTable(at, information, gradient, power, accepted, tuple(blocks))


def _one(at: JointFit, k: int, candidates: Sequence[Candidate]) -> tuple[Array, Array, Array]:
    """Information, gradient and power of one shot."""
    linear = at.linear[k]
    new = candidate_columns(at.started[k], at.hypothesis, at, k, candidates)
    return linear.projected(np.concatenate([linear.columns.T, new]))


def candidate_columns(
    started: PreparedShot, hypothesis: Hypothesis, at: JointFit, k: int, candidates: Sequence[Candidate]
) -> Array:
    """Columns of candidates in units of the noise, (sum of sizes, rows), in their order."""
    linear = at.linear[k]
    torque = _torque_columns(started, hypothesis, at, k, candidates)
    rows = []
    for c in candidates:
        if c.term is not None:
            rows.append(torque[c.key])
        else:
            assert c.columns is not None
            rows.append(started.white(c.columns(linear.seen)))
    return np.concatenate([np.empty((0, linear.seen.whitened.size)), *rows])


def _torque_columns(
    started: PreparedShot, hypothesis: Hypothesis, at: JointFit, k: int, candidates: Sequence[Candidate]
) -> dict[object, Array]:
    """Columns of the torque candidates by their keys, each (1, rows)."""
    torques = [c for c in candidates if c.term is not None]
    courses = [c for c in torques if c.f_nat_course is not None and _f_nat_is_free(hypothesis)]
    # Each value of a hidden scale takes a look of its own, and so does what else depends on time.
    alone = [c for c in torques if c not in courses and (c.hidden or (c.term is not None and c.term.timed))]
    found: dict[object, Array] = {}
    for group in ([c for c in torques if c not in courses and c not in alone], *([c] for c in alone)):
        if group:
            wide, values, seen = _look(started, hypothesis, at, k, group)
            _, rows = wide.torque_rows(at.states[k], values, seen.base)
            found |= {c.key: row[None] for c, row in zip(wide.torques, rows, strict=True)}
    if courses:
        model, (_, _, seen) = hypothesis.augmented, _look(started, hypothesis, at, k, [])
        for c in courses:
            assert c.f_nat_course is not None
            found[c.key] = started.white(f_nat_column(seen, model, seen.state, c.f_nat_course))[None]
    return found


def _f_nat_is_free(hypothesis: Hypothesis) -> bool:
    """True where a course of f_nat is what its own derivative says, window by window: it moves no other spring."""
    terms = hypothesis.augmented.terms
    return not hypothesis.augmented.time_dependent and not SPRINGS & {t.name for t in terms}


def _look(
    started: PreparedShot, hypothesis: Hypothesis, at: JointFit, k: int, group: Sequence[Candidate]
) -> tuple[Hypothesis, Array, Linearisation]:
    """A hypothesis with a group of torques of no strength beside it, its torques' strengths, and shot k seen by it."""
    wide = hypothesis.plus(*group)
    order = [*hypothesis.torques, *group]
    values = np.zeros(len(wide.torques))
    for place, c in enumerate(wide.torques):
        values[place] = at.strengths[order.index(c)] if c in hypothesis.torques else 0.0
    strengths = np.concatenate([values, at.strengths[len(hypothesis.torques) :]])
    seen = linearise_signal(started, wide.augmented, wide.extended(at.states[k], values))
    return wide, values, wide.through(seen, strengths)

"""The likeliest course of a torque of one shot.

With the strengths of all effects held, Gauss-Newton minimises |r(theta, x)|^2 + c |L^-1 x|^2 over the shot's own
parameters theta and the knots x of the course: r is the residual in units of the noise, L L^T the covariance of x by
the random process, and c the present chi^2 per degree of freedom, at least 1.  While the residual is c times the noise,
what the course gains counts c times less: it must not follow what other effects would explain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.information import inverse, solved
from platform_daemon.diagnosis.regression.linearised_shot import orthonormal
from platform_daemon.diagnosis.shots.linearisation import linearise_signal
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.torque_course import CourseState, ProcessNoise
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .process import CourseInformation

_LIMITS = THRESHOLDS.fluctuation


@dataclass(frozen=True, kw_only=True)
class CourseFit:
    """A shot with the course of a torque.

    Attributes:
        state: of the declared model, with the course.
        base: (rows, p) columns of the free declared parameters; knots: (rows, k) of the course; both orthogonal to the
            shot's own additive effects. free: bool, which parameters these are.
        residual: (rows,), likewise.
        settled: the fit has come to a minimum.
    """

    state: CourseState
    base: Array
    knots: Array
    free: np.ndarray
    residual: Array
    settled: bool = False

    @property
    def chi2(self) -> float:
        """Of the residual."""
        return float(self.residual @ self.residual)

    def own_covariance(self) -> Array:
        """Of the declared parameters beside the course, (p, p); 0 for those that are held."""
        columns = np.concatenate([self.base, self.knots], axis=1)
        count, root = self.base.shape[1], self.state.course.root
        inside = solve_triangular(root, np.eye(root.shape[0]), lower=True)
        matrix = columns.T @ columns
        matrix[count:, count:] += inside.T @ inside
        found = np.zeros((self.free.size, self.free.size))
        found[np.ix_(self.free, self.free)] = inverse(matrix)[:count, :count]
        return found

    def information(self, unit: float) -> CourseInformation:
        """What the shot tells about its course, its own parameters eliminated; unit: of a size of 1, rad/s^2.

        It is about a course of 0, to first order from the one that was found.
        """
        norm = np.linalg.norm(self.base, axis=0)
        q = np.linalg.qr(self.base / np.where(norm > 0.0, norm, 1.0))[0]
        at_zero = self.residual + self.knots @ self.state.course.values
        knots = self.knots - q @ (q.T @ self.knots)
        return CourseInformation(
            time_s=self.state.course.time_s,
            unit=unit,
            information=knots.T @ knots,
            gradient=knots.T @ (at_zero - q @ (q.T @ at_zero)),
        )


def fit_course(
    prepared: PreparedShot,
    hypothesis: Hypothesis,
    state: CourseState,
    strengths: Array,
    beside: Sequence[Candidate] = (),
    rows: np.ndarray | None = None,
) -> CourseFit:
    """The likeliest state and course of a shot.

    Args:
        prepared: the shot, without a course.
        hypothesis, strengths: the effects and their strengths (q,), held.
        state: where the fit begins.
        beside: receiver and additive effects that have a free size in this shot, to first order.
        rows: bool (rows,): the part of the shot that is fitted; None: all.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """

    def at(state: CourseState) -> CourseFit:
        return linearise_course(prepared, hypothesis, state, strengths, beside, rows)

    def cost(fit: CourseFit) -> float:
        return fit.chi2 + excess * float(np.sum((inside @ fit.state.course.values) ** 2))

    root = state.course.root
    here, inside = at(state), solve_triangular(root, np.eye(root.shape[0]), lower=True)
    dof = prepared.dof if rows is None else float(np.count_nonzero(rows)) * prepared.dof / rows.size
    for _ in range(_LIMITS.most_steps):
        excess = max(1.0, here.chi2 / dof)
        step, predicted = _step(here, inside * np.sqrt(excess))
        if predicted < _LIMITS.settled_chi2 * excess:
            return replace(here, settled=True)
        before, fraction = cost(here), 1.0
        while fraction > _LIMITS.smallest_fraction:
            try:
                there = at(here.state.moved(fraction * step))
            except LostTrajectoryError:
                fraction *= _LIMITS.shortening
                continue
            if cost(there) < before:
                break
            fraction *= _LIMITS.shortening
        else:
            break
        here = there
    return here


def _step(here: CourseFit, inside: Array) -> tuple[Array, float]:
    """Step of the free parameters and knots, and the fall of the cost that it predicts; inside: L^-1."""
    columns = np.concatenate([here.base, here.knots], axis=1)
    matrix, count = columns.T @ columns, here.base.shape[1]
    gradient = columns.T @ here.residual
    prior = inside.T @ inside
    matrix[count:, count:] += prior
    gradient[count:] -= prior @ here.state.course.values
    found = solved(matrix, gradient)
    step = np.zeros(here.free.size + here.knots.shape[1])
    step[np.flatnonzero(here.free)], step[here.free.size :] = found[:count], found[count:]
    return step, float(gradient @ found)


def linearise_course(
    prepared: PreparedShot,
    hypothesis: Hypothesis,
    state: CourseState,
    strengths: Array,
    beside: Sequence[Candidate] = (),
    rows: np.ndarray | None = None,
) -> CourseFit:
    """The shot at a state with a course; see fit_course.  Raises LostTrajectoryError."""
    full = hypothesis.extended(state, strengths)
    found = hypothesis.received(linearise_signal(prepared, hypothesis.augmented, full), strengths)
    every, inside = state.course.places(hypothesis.augmented)
    base, knots = np.delete(found.base, every, axis=0), found.base[inside]
    base, _ = hypothesis.torque_rows(state, strengths, base)
    free = hypothesis.free(base.shape[0])
    base, residual = base[free], found.whitened - hypothesis.additive_part(strengths, hypothesis.shared_columns(found))
    own = [hypothesis.own_columns(found)]
    own += [prepared.white(c.columns(found)) for c in beside if c.columns is not None]
    if rows is not None:
        base, knots, residual, own = base[:, rows], knots[:, rows], residual[rows], [x[:, rows] for x in own]
    pumped, root = found.pumped_amplitude(state.course)
    if len(pumped):
        walk = ProcessNoise.of(pumped if rows is None else pumped[:, rows], root)
        base, knots, residual, *own = (walk.taken_out(x) for x in (base, knots, residual, *own))
    q = orthonormal(np.concatenate(own).T)
    base, knots, residual = (x - (x @ q) @ q.T for x in (base, knots, residual))
    return CourseFit(state=state, base=base.T, knots=knots.T, free=free, residual=residual)

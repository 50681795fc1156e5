"""One linearised shot with its own parameters factored, of which a joint fit is the sum.

With Q R the factors of the columns of the own parameters, a joint fit needs of every shot only the common columns C and
the residual r: the sums of C^T (1 - Q Q^T) C and C^T (1 - Q Q^T) r are its normal equations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr, solve_triangular

from platform_daemon.diagnosis.shots.linearisation import Linearisation, linearise_signal
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.torque_course import course_of
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.correlation import samples_per_value

from .hypothesis import Hypothesis

_LIMITS = THRESHOLDS.regression


@dataclass(frozen=True, kw_only=True)
class LinearisedShot:
    """One shot at one state; "projected" means orthogonal to `own`.

    Attributes:
        linearisation: residual and derivatives at the state.
        own: orthonormal columns of the additive effects that the shot has for itself, (rows, k).
        q, triangle, scale: QR factors of the declared parameters' scaled columns, projected.
        free: bool (p,) which of the declared parameters these are; the others are held.
        columns: (rows, common) of the common strengths, projected.
        residual: (rows,) projected.
    """

    linearisation: Linearisation
    own: Array
    q: Array
    triangle: Array
    scale: Array
    free: np.ndarray
    columns: Array
    residual: Array

    @property
    def chi2(self) -> float:
        """Of the residual as it is."""
        return float(self.residual @ self.residual)

    @property
    def parameters(self) -> int:
        """Of this shot alone."""
        return int(self.q.shape[1] + self.own.shape[1])

    @property
    def samples_per_value(self) -> float:
        """Samples of the residual per independent value: 1 for white noise."""
        return self.samples_per_value_of(self.residual)

    def samples_per_value_of(self, residual: Array) -> float:
        """The same of another residual, flat (rows,)."""
        return samples_per_value(residual.reshape(self.linearisation.residual.shape))

    def without_own(self, columns: Array) -> Array:
        """Columns (rows, ...) orthogonal to those of all parameters that the shot has for itself."""
        for _ in range(2):
            columns = columns - self.own @ (self.own.T @ columns)
            columns = columns - self.q @ (self.q.T @ columns)
        return columns

    def projected(self, columns: Array) -> tuple[Array, Array, Array]:
        """Of columns (k, rows), the shot's own parameters eliminated: information (k, k), gradient, power (k,)."""
        inside = np.concatenate([columns @ self.own, columns @ self.q], axis=1)
        whole = columns @ columns.T
        gradient = columns @ self.residual - inside[:, self.own.shape[1] :] @ (self.q.T @ self.residual)
        return whole - inside @ inside.T, gradient, np.diag(whole).copy()

    def own_step(self, common: Array) -> Array:
        """Best step of the declared parameters given a step of the common strengths.

        Where the state has a course of a torque, the step of its knots follows: to the likeliest course then.
        """
        left = self.residual - self.columns @ common
        target = self.q.T @ left
        step = np.zeros(self.free.size)
        step[self.free] = solve_triangular(self.triangle, target) * self.scale
        course, process = course_of(self.linearisation.state), self.linearisation.process
        if course is None or process is None:
            return step
        knots = process.likeliest(left - self.q @ target)[: course.values.size]
        return np.concatenate([step, knots - course.values])

    def without_process(self) -> LinearisedShot:
        """A copy that does not know how the course of a torque follows, which takes most of its memory."""
        if self.linearisation.process is None:
            return self
        return replace(self, linearisation=self.linearisation.without_process())

    def own_covariance(self) -> Array:
        """Of the declared parameters at fixed common strengths, (p, p); 0 for those held."""
        inverse = solve_triangular(self.triangle, np.eye(self.triangle.shape[0])) * self.scale[:, None]
        out = np.zeros((self.free.size, self.free.size))
        out[np.ix_(self.free, self.free)] = inverse @ inverse.T
        return out

    def base(self) -> Array:
        """Columns of the declared parameters, (rows, p); 0 for those held."""
        out = np.zeros((self.q.shape[0], self.free.size))
        out[:, self.free] = (self.q @ self.triangle) / self.scale
        return out

    def without(self, state: FitState, held: Sequence[int], removed: Array, kept: np.ndarray) -> LinearisedShot:
        """The shot without some declared parameters (places `held`) and common strengths, as if these were 0.

        state: where it was linearised; removed (common,): strengths that are to become 0; kept bool (common,): those
        that stay in play.
        """
        base, free = self.base(), self.free.copy()
        free[held] = False
        values = np.array([state.dynamics.values[k - 3] for k in held])
        residual = self.residual + base[:, held] @ values + self.columns @ removed
        q, triangle, scale = _factors(base[:, free])
        return replace(
            self, q=q, triangle=triangle, scale=scale, free=free, columns=self.columns[:, kept], residual=residual
        )


def linearise_shot(prepared: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array) -> LinearisedShot:
    """One shot at a state of the declared model with the strengths put in.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    full = hypothesis.extended(state, strengths)
    linearisation = hypothesis.through(linearise_signal(prepared, hypothesis.augmented, full), strengths)
    shared = hypothesis.shared_columns(linearisation)
    base, torques = hypothesis.torque_rows(state, strengths, linearisation.base)
    columns, base = np.concatenate([torques, shared]).T, base.T
    residual = linearisation.whitened - hypothesis.additive_part(strengths, shared)
    free = hypothesis.free(base.shape[1])
    base = base[:, free]
    own = orthonormal(hypothesis.own_columns(linearisation).T)
    if own.shape[1]:
        base, columns, residual = (x - own @ (own.T @ x) for x in (base, columns, residual))
    q, triangle, scale = _factors(base)
    return LinearisedShot(
        linearisation=linearisation.without_jacobian(),
        own=own,
        q=q,
        triangle=triangle,
        scale=scale,
        free=free,
        columns=columns,
        residual=residual,
    )


def _factors(base: Array) -> tuple[Array, Array, Array]:
    """Orthonormal columns, triangle and scale of the columns of parameters."""
    norm = np.linalg.norm(base, axis=0)
    scale = 1.0 / np.where(norm > 0.0, norm, 1.0)
    q, triangle = (np.asarray(x, dtype=np.float64) for x in qr(base * scale, mode="economic"))
    return q, triangle, scale


def orthonormal(columns: Array) -> Array:
    """Orthonormal columns that span the same space."""
    if columns.shape[1] == 0:
        return columns
    norm = np.linalg.norm(columns, axis=0)
    q, triangle, _ = qr(columns / np.where(norm > 0.0, norm, 1.0), mode="economic", pivoting=True)
    size = np.abs(np.diag(triangle))
    return np.asarray(q[:, size > _LIMITS.dependent_share * max(size[0], _LIMITS.dependent_share)])


def common_information(shots: Iterable[LinearisedShot], size: int) -> tuple[Array, Array]:
    """Information (size, size) and gradient of the common strengths, the shots' own parameters eliminated."""
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    for a in shots:
        rest = a.columns - a.q @ (a.q.T @ a.columns)
        matrix += rest.T @ rest
        gradient += rest.T @ a.residual
    return matrix, gradient

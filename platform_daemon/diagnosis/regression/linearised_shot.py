"""One shot at one state, its own parameters in triangular form: what a joint fit adds up over the shots."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.linalg import qr, solve_triangular

from platform_daemon.estimation import Array, FitState

from ..shots.linearisation import Linearisation, linearise_signal
from ..shots.shot import PreparedShot
from .hypothesis import Hypothesis

_NOTHING = 1e-9  # share of a column that must be left beside the others


@dataclass(frozen=True)
class LinearisedShot:
    """One shot at one state: its own parameters in triangular form, the common strengths beside them.

    Attributes:
        seen: the look.
        own: orthonormal columns of the additive effects that the shot has for itself, (rows, k).
        q, triangle, scale: factors of the declared parameters' scaled columns beside `own`.
        free: bool (p,) which of the declared parameters these are; the others are held.
        columns: (rows, common) of the common strengths beside `own`.
        residual: (rows,) beside `own`.
    """

    seen: Linearisation
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
        """So many samples of the residual tell as much as one independent value would: 1 for white noise."""
        return self.samples_per_value_of(self.residual)

    def samples_per_value_of(self, residual: Array) -> float:
        """The same of what else may be left, flat (rows,).

        The sum of the squares of its correlations, without what chance adds to these.
        """
        rows: Array = residual.reshape(self.seen.residual.shape)
        n = int(self.seen.residual.shape[1])
        size = next_fast_len(2 * n, real=True)
        power = np.abs(rfft(rows, size, axis=1)) ** 2
        lags = np.asarray(irfft(power.sum(axis=0), size), dtype=np.float64)
        squares = (lags[:n] / max(float(lags[0]), 1e-300)) ** 2
        return max(1.0, 2.0 * float(squares.sum()) - 2.0)

    def beside(self, columns: Array) -> Array:
        """Columns (rows, ...) without what lies within the shot's own parameters."""
        for _ in range(2):
            columns = columns - self.own @ (self.own.T @ columns)
            columns = columns - self.q @ (self.q.T @ columns)
        return columns

    def projected(self, columns: Array) -> tuple[Array, Array, Array]:
        """Of columns (k, rows) beside the shot's own parameters: information (k, k), gradient, power (k,)."""
        inside = np.concatenate([columns @ self.own, columns @ self.q], axis=1)
        whole = columns @ columns.T
        gradient = columns @ self.residual - inside[:, self.own.shape[1] :] @ (self.q.T @ self.residual)
        return whole - inside @ inside.T, gradient, np.diag(whole).copy()

    def own_step(self, common: Array) -> Array:
        """Best step of the declared parameters beside a step of the common strengths."""
        target = self.q.T @ (self.residual - self.columns @ common)
        step = np.zeros(self.free.size)
        step[self.free] = solve_triangular(self.triangle, target) * self.scale
        return step

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

    def without(self, state: FitState, held: Sequence[int], gone: Array, kept: np.ndarray) -> LinearisedShot:
        """The shot without some declared parameters (places `held`) and common strengths, as if these were 0.

        state: where it was linearised; gone (common,): strengths that are to become 0; kept bool (common,): those
        that stay in play.
        """
        base, free = self.base(), self.free.copy()
        free[held] = False
        values = np.array([state.dynamics.values[k - 3] for k in held])
        residual = self.residual + base[:, held] @ values + self.columns @ gone
        return LinearisedShot(self.seen, self.own, *_factors(base[:, free]), free, self.columns[:, kept], residual)


def linearise_shot(started: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array) -> LinearisedShot:
    """One shot at a state of the declared model with the strengths put in.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    full = hypothesis.extended(state, strengths)
    seen = hypothesis.through(linearise_signal(started, hypothesis.augmented, full), strengths)
    shared = hypothesis.shared_columns(seen)
    base, torques = hypothesis.torque_rows(state, strengths, seen.base)
    columns, base = np.concatenate([torques, shared]).T, base.T
    residual = seen.whitened - hypothesis.additive_part(strengths, shared)
    free = hypothesis.free(base.shape[1])
    base = base[:, free]
    own = _orthonormal(hypothesis.own_columns(seen).T)
    if own.shape[1]:
        base, columns, residual = (x - own @ (own.T @ x) for x in (base, columns, residual))
    return LinearisedShot(seen.without_jacobian(), own, *_factors(base), free, columns, residual)


def _factors(base: Array) -> tuple[Array, Array, Array]:
    """Orthonormal columns, triangle and scale of the columns of parameters."""
    norm = np.linalg.norm(base, axis=0)
    scale = 1.0 / np.where(norm > 0.0, norm, 1.0)
    q, triangle = (np.asarray(x, dtype=np.float64) for x in qr(base * scale, mode="economic"))
    return q, triangle, scale


def _orthonormal(columns: Array) -> Array:
    """Orthonormal columns that span the same space."""
    if columns.shape[1] == 0:
        return columns
    norm = np.linalg.norm(columns, axis=0)
    q, triangle, _ = qr(columns / np.where(norm > 0.0, norm, 1.0), mode="economic", pivoting=True)
    size = np.abs(np.diag(triangle))
    return np.asarray(q[:, size > _NOTHING * max(size[0], _NOTHING)])


def common_information(shots: Iterable[LinearisedShot], size: int) -> tuple[Array, Array]:
    """Matrix (size, size) and gradient of the common strengths beside everything that the shots have for themselves."""
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    for a in shots:
        rest = a.columns - a.q @ (a.q.T @ a.columns)
        matrix += rest.T @ rest
        gradient += rest.T @ a.residual
    return matrix, gradient

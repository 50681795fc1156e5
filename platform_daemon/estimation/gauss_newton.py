"""Least squares on moments: one pass over the samples gives residual, gradient and normal matrix exactly.

Parameter vector of a step: (theta, w, A, q..., own parameters of the observation..., offsets (channels,)).
With the kernel's basis B (n_basis, n), channel c of the model is x_c . B and its Jacobian C_c^T B, so that
chi^2, gradient and J^T J follow from the small matrices of Moments alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .arrays import Array
from .models import RingDownModel
from .observation import Observation
from .trajectory import Dynamics, Moments


@dataclass(frozen=True)
class FitState:
    """Everything that is fitted: the motion, how it is seen, and a constant offset per channel."""

    dynamics: Dynamics
    observation: Observation
    offsets: Array

    @property
    def size(self) -> int:
        """Length of the parameter vector."""
        return 3 + len(self.dynamics.values) + self.observation.size + self.offsets.size

    def moved(self, step: Array) -> FitState:
        """The state after a step."""
        d = self.dynamics
        k = 3 + len(d.values)
        m = k + self.observation.size
        dynamics = Dynamics(
            w=d.w + float(step[1]),
            theta=d.theta + float(step[0]),
            amplitude=d.amplitude + float(step[2]),
            values=tuple(q + float(dq) for q, dq in zip(d.values, step[3:k], strict=True)),
        )
        return FitState(dynamics, self.observation.moved(step[k:m]), self.offsets + step[m:])

    def mirrored(self) -> FitState:
        """phi -> -phi, for conventions."""
        return replace(self, dynamics=replace(self.dynamics, amplitude=-self.dynamics.amplitude))


def with_best_gains(state: FitState, moments: Moments) -> FitState:
    """The state with the gains and offsets that fit its trajectory best, if its gains are free.

    They are linear, so they follow from the moments exactly. Without this, gain times amplitude makes a curved
    valley that Gauss-Newton zigzags along.
    """
    which = [0, 1, moments.gram.shape[0] - 1]
    gram = moments.gram[np.ix_(which, which)]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    solution = np.linalg.lstsq(gram * np.outer(scale, scale), (moments.products[:, which] * scale).T, rcond=None)[0]
    best = (solution * scale[:, None]).T
    observation = state.observation.with_gains(best[:, :2], state.dynamics.w)
    return state if observation is None else replace(state, observation=observation, offsets=best[:, 2])


@dataclass(frozen=True)
class Normal:
    """Quadratic model of chi^2 around a state: chi2 - 2 gradient.step + step.matrix.step."""

    chi2: float
    chi2_by_channel: Array
    squares_by_channel: Array
    gradient: Array
    matrix: Array


def normal_equations(model: RingDownModel, state: FitState, moments: Moments, noise_sd: Array) -> Normal:
    """Weighted least squares of a window from its moments; noise_sd (channels,)."""
    size, channels = state.size, state.offsets.size
    gradient, matrix = np.zeros(size), np.zeros((size, size))
    chi2, squares = np.empty(channels), np.empty(channels)
    values, jacobians = _channel_coefficients(model, state, moments.gram.shape[0])
    for c in range(channels):
        weight = noise_sd[c] ** -2
        explained = moments.gram @ values[c]
        # Rounding can make the squares of a noise-free record negative.
        squares[c] = max(moments.energy[c] - values[c] @ (2.0 * moments.products[c] - explained), 0.0)
        chi2[c] = weight * squares[c]
        gradient += weight * jacobians[c].T @ (moments.products[c] - explained)
        matrix += weight * jacobians[c].T @ moments.gram @ jacobians[c]
    return Normal(float(chi2.sum()), chi2, squares, gradient, matrix)


def _channel_coefficients(model: RingDownModel, state: FitState, n_basis: int) -> tuple[Array, Array]:
    """x_c (channels, n_basis) and C_c (channels, n_basis, size)."""
    d, obs = state.dynamics, state.observation
    channels = state.offsets.size
    gains, by_w, by_own = obs.gains(d.w), obs.gains_by_w(d.w), obs.gains_by_own(d.w)
    dynamic = 3 + len(d.values)
    chain = d.chain(model)
    values = np.zeros((channels, n_basis))
    values[:, :2] = gains
    values[:, -1] = state.offsets
    jacobians = np.zeros((channels, n_basis, state.size))
    for p in range(dynamic):
        jacobians[:, 2 + 2 * p, :dynamic] = gains[:, :1] * chain[p]
        jacobians[:, 3 + 2 * p, :dynamic] = gains[:, 1:] * chain[p]
    jacobians[:, :2, 1] += by_w
    jacobians[:, :2, dynamic : dynamic + obs.size] = np.moveaxis(by_own, 0, -1)
    for c in range(channels):
        jacobians[c, -1, dynamic + obs.size + c] = 1.0
    return values, jacobians


def solve_step(normal: Normal, free: np.ndarray, damping: float = 0.0) -> tuple[Array, float]:
    """Step of the free parameters (others 0) and the fall of chi^2 it predicts; columns are scaled to unit norm.

    Raises:
        numpy.linalg.LinAlgError: singular even after scaling.
    """
    matrix = normal.matrix[np.ix_(free, free)]
    gradient = normal.gradient[free]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * np.outer(scale, scale)
    solution = scale * np.linalg.solve(scaled + damping * np.eye(scale.size), scale * gradient)
    step = np.zeros(free.size)
    step[free] = solution
    return step, float(solution @ (2.0 * gradient - matrix @ solution))


def covariance(normal: Normal, free: np.ndarray) -> tuple[Array, float]:
    """Covariance of the free parameters (k, k) and the condition number of the scaled normal matrix."""
    matrix = normal.matrix[np.ix_(free, free)]
    scale = 1.0 / np.sqrt(np.diag(matrix))
    scaled = matrix * np.outer(scale, scale)
    return np.linalg.inv(scaled) * np.outer(scale, scale), float(np.linalg.cond(scaled))

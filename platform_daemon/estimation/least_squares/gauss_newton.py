"""Least squares on moments: one pass over the samples gives residual, gradient and normal matrix exactly.

Parameter vector of a step: (theta, w, A, q..., own parameters of the observation..., offsets (channels,)).
With the kernel's basis B (n_basis, n), channel c of the model is x_c . B and its Jacobian C_c^T B, so that
chi^2, gradient and J^T J follow from the small matrices of Moments alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.moments.workspace import Moments
from platform_daemon.estimation.numerics.arrays import Array, grown
from platform_daemon.estimation.numerics.linear_systems import solve_scaled
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torques import OF_OTHER_SIGN_IN_MIRROR
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters

from .normal_equations import assemble_normal_equations, coefficients
from .observation_model import Observation


@dataclass(frozen=True)
class FitState:
    """Everything that is fitted: the motion, how it is seen, and a constant offset per channel."""

    dynamics: MotionParameters
    observation: Observation
    offsets: Array

    @property
    def size(self) -> int:
        """Length of the parameter vector."""
        return 3 + len(self.dynamics.values) + self.observation.size + self.offsets.size

    def moved(self, step: Array) -> FitState:
        """The state after a step; what is multiplied, amplitude and moment, grows by a factor.

        A small oscillation determines little but their product: to first order, steps along a constant product would
        leave it, and Gauss-Newton would zigzag along a curved valley.
        """
        d = self.dynamics
        k = 3 + len(d.values)
        m = k + self.observation.size
        by_theta, by_w, by_amplitude, *by_values = step[:k].tolist()
        values = tuple(q + dq for q, dq in zip(d.values, by_values, strict=True))
        dynamics = MotionParameters(
            w=d.w + by_w, theta=d.theta + by_theta, amplitude=grown(d.amplitude, by_amplitude), values=values
        )
        return FitState(dynamics, self.observation.moved(step[k:m]), self.offsets + step[m:])

    def mirrored(self, model: RingDownModel) -> FitState:
        """phi -> -phi, for conventions."""
        d = self.dynamics
        pairs = zip(model.coefficients, d.values, strict=True)
        values = tuple(-q if c.name in OF_OTHER_SIGN_IN_MIRROR else q for c, q in pairs)
        return replace(self, dynamics=replace(d, amplitude=-d.amplitude, values=values))


def with_best_gains(state: FitState, moments: Moments) -> FitState:
    """The state with the gains and offsets that fit its trajectory best, if its gains are free.

    They are linear, so they follow from the moments exactly. Without this, gain times amplitude makes a curved
    valley that Gauss-Newton zigzags along.
    """
    if state.observation.ties_amplitude:
        return state
    which = [0, 1, moments.gram.shape[0] - 1]
    gram = moments.gram[np.ix_(which, which)]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    solution = np.linalg.lstsq(gram * np.outer(scale, scale), (moments.products[:, which] * scale).T, rcond=None)[0]
    best = (solution * scale[:, None]).T
    observation = state.observation.with_gains(best[:, :2], state.dynamics.w)
    return state if observation is None else replace(state, observation=observation, offsets=best[:, 2])


@dataclass(frozen=True, kw_only=True)
class NormalEquations:
    """Quadratic model of chi^2 around a state: chi2 - 2 gradient.step + step.matrix.step.

    samples: per channel, that took part. data_chi2: chi^2 of the data alone, the scale of rounding.
    """

    chi2: float
    chi2_by_channel: Array
    squares_by_channel: Array
    gradient: Array
    matrix: Array
    samples: int
    data_chi2: float = 0.0


def normal_equations(model: RingDownModel, state: FitState, moments: Moments, weights: Array) -> NormalEquations:
    """Weighted least squares of a window from its moments; weights (channels,): inverse variances of the noise."""
    gradient, matrix, squares = assembled(model, state, moments, weights)
    chi2 = weights * squares
    return NormalEquations(
        chi2=sum(chi2.tolist()),
        chi2_by_channel=chi2,
        squares_by_channel=squares,
        gradient=gradient,
        matrix=matrix,
        samples=moments.samples,
        data_chi2=float(weights @ moments.energy),
    )


def after_step(
    normal: NormalEquations, model: RingDownModel, state: FitState, moments: Moments, step: Array
) -> NormalEquations:
    """The normal equations with the residual that a small step leaves, by the linear model itself."""
    squares = assembled(model, state, moments, np.ones(normal.squares_by_channel.size), step)[2]
    by_channel = normal.chi2_by_channel * (squares / np.maximum(normal.squares_by_channel, 1e-300))
    return replace(normal, chi2=float(by_channel.sum()), chi2_by_channel=by_channel, squares_by_channel=squares)


def assembled(
    model: RingDownModel, state: FitState, moments: Moments, weights: Array, step: Array | None = None
) -> tuple[Array, Array, Array]:
    """Gradient, matrix and squares by channel (normal_equations.py), by the linear model after a step."""
    size = state.size
    out = np.zeros(size), np.zeros((size, size)), np.empty(weights.size)
    step = np.zeros(size) if step is None else step
    assemble_normal_equations(
        *linearised(model, state), moments.gram, moments.products, moments.energy, weights, step, *out
    )
    return out


def linearised(model: RingDownModel, state: FitState) -> tuple[Array, Array, Array, Array, Array]:
    """How basis coefficients follow from the parameters: chain, gains, their derivatives, offsets."""
    d, obs = state.dynamics, state.observation
    return d.chain(model), *obs.linear(d.w), state.offsets


def coefficient_jacobian(model: RingDownModel, state: FitState) -> Array:
    """Derivatives of the channels' coefficients in the kernel's basis by all parameters, (size, channels, b).

    Times the basis (b, n) it is the Jacobian of the signal; its odd places belong to the second function, f2.
    """
    linear = linearised(model, state)
    # Two functions, their slopes, their derivatives by w and by the motion's other parameters, and the constant.
    b = 3 + 2 * linear[0].shape[0]
    out, unused = np.empty((state.offsets.size, b, state.size)), np.empty(b)
    for channel in range(state.offsets.size):
        coefficients(*linear, channel, unused, out[channel])
    return np.ascontiguousarray(out.transpose(2, 0, 1))


def gauss_newton_step(normal: NormalEquations, free: np.ndarray, damping: float = 0.0) -> tuple[Array, float]:
    """Step of the free parameters (others 0) and the fall of chi^2 it predicts; columns are scaled to unit norm.

    Raises:
        numpy.linalg.LinAlgError: singular even after scaling.
    """
    step = np.empty(free.size)
    predicted = float(solve_scaled(normal.matrix, normal.gradient, free, damping, step))
    if not math.isfinite(predicted):
        raise np.linalg.LinAlgError("singular normal equations")
    return step, predicted


def covariance(normal: NormalEquations, free: np.ndarray) -> tuple[Array, float]:
    """Covariance of the free parameters (k, k) and the condition number of the scaled normal matrix."""
    matrix = normal.matrix[free][:, free]
    scale = 1.0 / np.sqrt(matrix.diagonal())
    scales = scale * scale[:, None]
    values, vectors = np.linalg.eigh(matrix * scales)
    return (vectors / values) @ vectors.T * scales, float(values[-1] / abs(values[0]))


def variance_of(direction: Array, normal: NormalEquations, free: np.ndarray) -> float:
    """Variance of a linear combination (size,) of the parameters; not finite if the equations are singular."""
    step = np.empty(free.size)
    fall = float(solve_scaled(normal.matrix, direction, free, 0.0, step))
    return float(direction @ step) if math.isfinite(fall) else math.inf

"""A residual together with what the fit could still move: the material of tests for what a model lacks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import rfft

from platform_daemon.estimation.least_squares.gauss_newton import FitState, coefficient_jacobian
from platform_daemon.estimation.least_squares.noise_weighting import is_even
from platform_daemon.estimation.least_squares.public_parameters import public_jacobian
from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import Trajectory
from platform_daemon.estimation.thresholds import THRESHOLDS

from .residual import Residual

LIMITS = THRESHOLDS.goodness_of_fit


@dataclass(frozen=True)
class LinearisedResidual:
    """Block means of a residual and of the fitted signal's derivatives.

    Attributes:
        scaled: (channels, n) residual in units of the noise.
        motion: (channels, n) fitted signal in the same units.
        derivatives: (p, channels, n) of the fitted signal by all parameters of the fit, in any scale.
        sd: (channels,) the noise.
        rate_hz: points per second.
        fundamental_hz: of the fitted motion at its beginning.
        names, values: (m,) of the published parameters.
        published: (m, p) their derivatives by all parameters of the fit.
    """

    scaled: Array
    motion: Array
    derivatives: Array
    sd: Array
    rate_hz: float
    fundamental_hz: float
    names: tuple[str, ...]
    values: Array
    published: Array

    def beginning(self, n: int) -> LinearisedResidual:
        """The first n points."""
        return replace(
            self, scaled=self.scaled[:, :n], motion=self.motion[:, :n], derivatives=self.derivatives[..., :n]
        )


def linearise_residual(
    residual: Residual, *, model: RingDownModel, state: FitState, free: np.ndarray, first: int, dt_s: float
) -> LinearisedResidual:
    """Integrate the motion again with its sensitivities; first: sample at which the window begins."""
    block = round(1.0 / (residual.rate_hz * dt_s))
    derivatives = derivatives_of(model, state, first=first, blocks=residual.scaled.shape[1], block=block, dt_s=dt_s)[
        free
    ]
    # Elliptic integral to second order: good to a thousandth at 60 degrees.
    slowing = 1.0 - state.dynamics.amplitude**2 / 16.0
    names, values, published = public_jacobian(model, state)
    return LinearisedResidual(
        scaled=residual.scaled,
        motion=residual.model / residual.sd[:, None],
        derivatives=derivatives / residual.sd[:, None],
        sd=residual.sd,
        rate_hz=residual.rate_hz,
        fundamental_hz=state.dynamics.w / (2.0 * math.pi) * slowing,
        names=tuple(names),
        values=values,
        published=published[:, free],
    )


def derivatives_of(
    model: RingDownModel,
    state: FitState,
    *,
    first: int,
    blocks: int,
    block: int,
    dt_s: float,
    sd: Array | None = None,
    trajectory: Trajectory | None = None,
) -> Array:
    """Block means of the signal's derivatives by all parameters, (size, channels, blocks).

    sd: (channels, 2) that odd and even harmonics are divided by, None: 1.  trajectory: that of the state to the end of
    the blocks at least, None: it is traced.
    """
    seen = state.observation
    if trajectory is None:
        trajectory = Trajectory(model, state.dynamics, (first + blocks * block) * dt_s)
    jacobian = coefficient_jacobian(model, state)
    if sd is not None:
        jacobian = jacobian / sd[:, is_even(state, jacobian.shape[2]).astype(np.int64)]
    out = np.empty((*jacobian.shape[:2], blocks))
    for begin in range(0, blocks, LIMITS.jacobian_chunk):
        end = min(begin + LIMITS.jacobian_chunk, blocks)
        basis = trajectory.basis(first + begin * block, first + end * block, dt_s, seen.observable)
        means = basis.reshape(basis.shape[0], end - begin, block).mean(axis=2)
        out[..., begin:end] = np.tensordot(jacobian, means, 1)
    return out


def fitted_subspace(given: LinearisedResidual) -> Array:
    """Orthonormal basis (k, channels, n) of what the fit and a gain per channel can move."""
    return orthonormal(np.concatenate([given.derivatives, _gains(given.motion)]))


def projected_out(signal: Array, known: Array) -> Array:
    """A signal (channels, n) without its part in the space of an orthonormal basis (k, channels, n)."""
    return np.asarray(signal - np.tensordot(np.tensordot(known, signal, 2), known, 1))


def noise_power(left: Array) -> float:
    """Power of the noise in a point of a residual (channels, n), by the median of its spectrum."""
    return float(np.median(np.abs(rfft(left, axis=1)) ** 2)) / (left.shape[1] * math.log(2.0))


def phase_of(given: LinearisedResidual) -> Array:
    """Phase in rad of the fitted motion, (n,), from the direction in which it is strongest."""
    motion = given.motion * given.sd[:, None]
    strongest = np.linalg.svd(motion @ motion.T)[0][:, 0]
    phase = np.unwrap(np.angle(_analytic((strongest @ motion)[None, :])[0]))
    # A single channel may see little but the second harmonic.
    turns = (phase[-1] - phase[0]) / (2.0 * math.pi)
    harmonic = max(1, round(turns * given.rate_hz / phase.size / given.fundamental_hz))
    return np.asarray(phase / harmonic)


def _analytic(signal: Array) -> ComplexArray:
    """The signal (channels, n) and its quadrature, as a complex number."""
    from scipy.signal import hilbert  # here, because few fits get this far

    return np.asarray(hilbert(signal, axis=1))


def _gains(motion: Array) -> Array:
    """The fitted motion of each channel and its quadrature, (2 channels, channels, n)."""
    quadrature = _analytic(motion).imag
    return np.concatenate([np.eye(motion.shape[0])[:, :, None] * part[:, None, :] for part in (motion, quadrature)])


def orthonormal(rows: Array) -> Array:
    """An orthonormal basis of the space of rows (k, channels, n)."""
    flat = rows.reshape(rows.shape[0], -1)
    norms = np.linalg.norm(flat, axis=1)
    flat = flat[norms > 0.0] / norms[norms > 0.0, None]
    _, values, basis = np.linalg.svd(flat, full_matrices=False)
    return np.asarray(basis[values > LIMITS.subspace_share * values[0]].reshape(-1, *rows.shape[1:]))

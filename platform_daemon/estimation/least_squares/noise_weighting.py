"""Last steps of a fit in coloured noise: every harmonic weighted by the noise at its frequency.

The fit converges with one standard deviation per channel, which is unbiased for noise of any colour. Odd harmonics are
in the first of the observed pair of functions, even ones in the second; weighting each with its own noise makes the
estimates the best ones again and their covariance the true one. In white noise nothing changes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.moments.workspace import Moments
from platform_daemon.estimation.noise.coloured import is_white, sd_at
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.thresholds import THRESHOLDS

from .gauss_newton import FitState, NormalEquations, assembled, gauss_newton_step
from .problem import FitProblem, Minimum
from .public_parameters import by_convention

LIMITS = THRESHOLDS.least_squares


def weighted_by_harmonic(
    problem: FitProblem, best: Minimum, last: int, noise: NoiseModel, frequency_hz: float
) -> Minimum:
    """The minimum with odd and even harmonics weighted by the noise at f and 2 f; unchanged if that is white.

    chi^2 stays that of the problem's own standard deviations.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: the steps lead nowhere.
    """
    if is_white(noise, frequency_hz, problem.record.sampling_rate_hz):
        return best
    sd = harmonic_sd(problem, noise, frequency_hz)
    level = problem.noise_sd[:, None]
    if (np.abs(sd - level) <= LIMITS.same_level_share * level).all():
        return best
    state = by_convention(best.state, problem.model)
    for _ in range(LIMITS.weighting_steps):
        at = problem.evaluate(state, last)
        normal = weighted_normal(problem.model, at.state, at.moments, sd, at.normal)
        normal = problem.knowledge.added(normal, at.state)
        step, _ = gauss_newton_step(normal, problem.free)
        state = at.state.moved(step)
    left = problem.after(at, step)
    return replace(
        best,
        state=state,
        tabulated=state,
        left=0.0,
        normal=replace(left, gradient=normal.gradient, matrix=normal.matrix),
        moments=at.moments,
        sd=sd,
    )


def harmonic_sd(problem: FitProblem, noise: NoiseModel, frequency_hz: float) -> Array:
    """Standard deviations of white noise that weighs as much at f and at 2 f, (channels, 2)."""
    harmonics = frequency_hz * np.array([1.0, 2.0])
    # Below the rounding of a noise-free record a spectrum means nothing.
    known = (problem.noise_sd <= noise.sd)[:, None]
    level = sd_at(noise, harmonics, problem.record.sampling_rate_hz)
    usable = known & np.isfinite(level) & (level > 0.0)
    return np.where(usable, level, problem.noise_sd[:, None])


def is_even(state: FitState, functions: int) -> NDArray[np.bool_]:
    """Which of so many basis functions are even harmonics, (functions,)."""
    return (np.arange(functions) % 2 == 1) & (state.observation.observable == DIPOLE)


def weighted_normal(
    model: RingDownModel, state: FitState, moments: Moments, sd: Array, normal: NormalEquations
) -> NormalEquations:
    """Normal equations with a standard deviation for odd and even harmonics of every channel, sd (channels, 2).

    Rows of the residual's products with the basis get the weights 1/sd^2 of their harmonic, and the matrix of their
    covariance follows.
    """
    even = is_even(state, moments.gram.shape[0])
    gains, channels = state.observation.gains(state.dynamics.w), moments.products.shape[0]
    gradient, matrix = np.zeros_like(normal.gradient), np.zeros_like(normal.matrix)
    for channel in range(channels):
        root = 1.0 / sd[channel][even.astype(np.int64)]
        values = np.zeros(root.size)
        values[:2], values[-1] = gains[channel], state.offsets[channel]
        gram = moments.gram * np.outer(root, root)
        products = moments.products.copy()
        products[channel] = root**2 * (products[channel] - moments.gram @ values) + gram @ values
        one = np.zeros(channels)
        one[channel] = 1.0
        by, of, _ = assembled(model, state, replace(moments, gram=gram, products=products), one)
        gradient += by
        matrix += of
    return replace(normal, gradient=gradient, matrix=matrix)

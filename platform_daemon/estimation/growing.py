"""The fit's schedule: Gauss-Newton on windows that double, from a few periods to the whole."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .arrays import Array
from .gauss_newton import FitState, Normal, normal_equations, solve_step, with_best_gains
from .models import RingDownModel
from .record import RingDownRecord
from .trajectory import LostTrajectoryError, Trajectory

_EARLY_TOLERANCE = 0.3
_FINAL_TOLERANCE = 1e-4
_MOST_ITERATIONS = 30
_MOST_PASSES = 250
_PRIOR_WIDTH = 3.0  # of a coefficient's typical size
_PRIOR_AMPLITUDE = 0.5  # of the start value


class NoConvergenceError(ArithmeticError):
    """Gauss-Newton found no way down."""


@dataclass
class Problem:
    """A record, a model and its noise; counts the passes over the samples."""

    record: RingDownRecord
    model: RingDownModel
    noise_sd: Array
    free: np.ndarray
    first: int
    passes: int = 0
    _energies: dict[int, Array] = field(default_factory=dict)

    def normal(self, state: FitState, last: int) -> tuple[FitState, Normal]:
        """Normal equations over samples first .. last-1; one trace and one pass.

        The state comes back with its free gains, if it has any, put at their best for this trajectory.

        Raises:
            LostTrajectoryError: the state does not oscillate.
        """
        if last not in self._energies:
            window = self.record.samples[:, self.first : last]
            self._energies[last] = np.einsum("ij,ij->i", window, window)
        self.passes += 1
        if self.passes > _MOST_PASSES:
            raise NoConvergenceError(f"no minimum within {_MOST_PASSES} passes over the samples")
        dt = self.record.dt_s
        trajectory = Trajectory(self.model, state.dynamics, last * dt)
        moments = trajectory.moments(
            self.record.samples, self.first, last, dt, state.observation.observable, self._energies[last]
        )
        state = with_best_gains(state, moments)
        return state, normal_equations(self.model, state, moments, self.noise_sd)


@dataclass(frozen=True)
class Prior:
    """Gaussian knowledge for windows too short to tell everything: of the amplitude, then of the loss coefficients.

    mean, precision: (1 + coefficients,), precision 0 where nothing is known.
    """

    mean: Array
    precision: Array

    def added(self, normal: Normal, state: FitState) -> Normal:
        """Normal equations with the prior's pull."""
        d = state.dynamics
        miss = self.mean - np.array([d.amplitude, *d.values])
        gradient, matrix = normal.gradient.copy(), normal.matrix.copy()
        k = slice(2, 2 + miss.size)
        gradient[k] += self.precision * miss
        matrix[k, k] += np.diag(self.precision)
        chi2 = normal.chi2 + float(np.sum(self.precision * miss**2))
        return replace(normal, chi2=chi2, gradient=gradient, matrix=matrix)


def weak_prior(model: RingDownModel, state: FitState) -> Prior:
    """Typical losses give or take three times themselves; the last term, which took up the decay, is left free.

    Where nothing but the small anharmonicity tells the amplitude, half of the start value is its standard deviation.
    """
    d = state.dynamics
    widths = [_PRIOR_WIDTH * c.typical * d.w**c.power for c in model.coefficients]
    if widths:
        widths[-1] *= 30.0
    amplitude = np.inf if state.observation.ties_amplitude else _PRIOR_AMPLITUDE * abs(d.amplitude)
    return Prior(np.array([d.amplitude, *d.values]), np.array([amplitude, *widths]) ** -2.0)


@dataclass(frozen=True)
class Fitted:
    """The minimum: state, and the normal equations one negligible step before it."""

    state: FitState
    normal: Normal


def fit_growing(problem: Problem, start: FitState, start_periods: float, last: int) -> Fitted:
    """Minimise chi^2 over samples first .. last-1, on windows growing by two from the start's own stretch.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: no minimum was found.
    """
    period = 2.0 * np.pi / start.dynamics.w * problem.record.sampling_rate_hz
    length = max(int(start_periods * period), 32)
    prior = weak_prior(problem.model, start)
    state = start
    while problem.first + length < last:
        state = _minimise(problem, state, problem.first + length, prior, _EARLY_TOLERANCE).state
        length *= 2
    return _minimise(problem, state, last, None, _FINAL_TOLERANCE)


def _minimise(problem: Problem, state: FitState, last: int, prior: Prior | None, tolerance: float) -> Fitted:
    """Damped Gauss-Newton until the predicted fall of chi^2 is below the tolerance."""
    state, normal = _evaluate(problem, state, last, prior)
    damping = 0.0
    for _ in range(_MOST_ITERATIONS):
        step, predicted = solve_step(normal, problem.free, damping)
        if not np.isfinite(predicted):
            raise NoConvergenceError("the normal equations are not finite")
        shrink = _shrink(state, step, last * problem.record.dt_s)
        if predicted < tolerance and damping == 0.0 and shrink == 1.0:
            return Fitted(state.moved(step), normal)
        trial = state.moved(shrink * step)
        try:
            trial, trial_normal = _evaluate(problem, trial, last, prior)
        except LostTrajectoryError:
            trial_normal = None
        if trial_normal is not None and trial_normal.chi2 <= normal.chi2 * (1.0 + 1e-12) + 1e-6:
            state, normal = trial, trial_normal
            damping = 0.1 * damping if damping > 1e-6 else 0.0
        else:
            damping = max(1e-4, 10.0 * damping)
        if damping > 1e8:
            break
    raise NoConvergenceError(f"no minimum after {_MOST_ITERATIONS} iterations")


def _evaluate(problem: Problem, state: FitState, last: int, prior: Prior | None) -> tuple[FitState, Normal]:
    """State and normal equations, with the prior if there is one."""
    state, normal = problem.normal(state, last)
    return state, normal if prior is None else prior.added(normal, state)


def _shrink(state: FitState, step: Array, t_end_s: float) -> float:
    """Largest fraction of a step for which the linearisation can still hold."""
    excess = max(
        abs(step[0]) / 0.7,
        abs(step[1]) * t_end_s / 2.0,
        abs(step[2]) / (0.4 * abs(state.dynamics.amplitude)),
    )
    return 1.0 if excess <= 1.0 else 1.0 / excess

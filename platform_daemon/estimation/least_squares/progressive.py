"""The stages of a fit: Gauss-Newton on growing windows, from a few periods to the whole.

The quick schedule looks at some of the half cycles only until the last passes over everything; the careful one looks
at all of them, on windows that double, and takes over where the quick one fails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..numerics.arrays import Array
from ..numerics.chebyshev import COARSE, EXACT
from ..physics.models import RingDownModel
from ..physics.trajectory.basis_functions import DIPOLE
from ..physics.trajectory.direct import LostTrajectoryError
from .gauss_newton import FitState, NormalEquations, solve_step, variance_of
from .problem import ALL_SAMPLES, ROUNDING, Evaluation, FitProblem, Minimum, NoConvergenceError, Subsample

_MOST_ITERATIONS = 30
_SURE_PHASE = 0.05  # rad
_CAUTION = 4.0
_NEGLIGIBLE_FALL = 0.2  # of chi^2, in its standard deviations
_ENOUGH_SAMPLES = 3000  # for an early pass
_ENOUGH_IN_HALF_CYCLE = 24
_MOST_LEFT_OUT = 15  # an early pass looks at no less than one in so many samples
_PRIOR_WIDTH = 3.0  # of a coefficient's typical size
_PRIOR_AMPLITUDE = 0.5  # of the start value


@dataclass(frozen=True)
class FitStages:
    """How a fit proceeds.

    Attributes:
        growth: of the window from stage to stage, at most.
        early, late, final: fall of chi^2 still to come at which a stage ends: the growing windows, a last look at some
            of the whole, all of it.
        half_cycles: of so many the early passes take a sample, evenly spread over the window.
        last_share: the last of them looks at no smaller share of the half cycles than this.
        digits: of the trajectory in the early passes.
    """

    growth: float
    early: float
    late: float
    final: float
    half_cycles: int
    last_share: float
    digits: float


QUICK = FitStages(16.0, 100.0, 1e3, 1e-3, 33, 0.1, COARSE)
CAREFUL = FitStages(2.0, 0.3, 0.3, 1e-4, 1 << 60, 1.0, EXACT)


@dataclass(frozen=True)
class Prior:
    """Gaussian knowledge for windows too short to tell everything: of the amplitude, then of the loss coefficients.

    mean, precision: (1 + coefficients,), precision 0 where nothing is known.
    """

    mean: Array
    precision: Array

    def added(self, normal: NormalEquations, state: FitState) -> NormalEquations:
        """Normal equations with the prior's pull."""
        d = state.dynamics
        miss = self.mean - np.array([d.amplitude, *d.values])
        gradient, matrix = normal.gradient.copy(), normal.matrix.copy()
        pull = self.precision * miss
        gradient[2 : 2 + miss.size] += pull
        matrix.reshape(-1)[:: gradient.size + 1][2 : 2 + miss.size] += self.precision  # the diagonal
        chi2 = normal.chi2 + float(pull @ miss)
        return replace(normal, chi2=chi2, gradient=gradient, matrix=matrix)


def weak_prior(model: RingDownModel, state: FitState) -> Prior:
    """Coefficients give or take three times their start or typical value; the loss that took up the decay is free.

    Where nothing but the small anharmonicity tells the amplitude, half of the start value is its standard deviation.
    """
    d = state.dynamics
    names = [c.name for c in model.coefficients]
    sizes = [max(c.typical * d.w**c.power, abs(q)) for c, q in zip(model.coefficients, d.values, strict=True)]
    widths = [_PRIOR_WIDTH * size for size in sizes]
    # The turning points of an angle tell the losses better than the drift of a harmonic does.
    if model.losses and state.observation.observable == DIPOLE:
        widths[names.index(model.losses[-1])] *= 30.0
    amplitude = np.inf if state.observation.ties_amplitude else _PRIOR_AMPLITUDE * abs(d.amplitude)
    return Prior(np.array([d.amplitude, *d.values]), np.array([amplitude, *widths]) ** -2.0)


def fit_progressively(
    problem: FitProblem, start: FitState, start_periods: float, last: int, schedule: FitStages = CAREFUL
) -> Minimum:
    """Minimise chi^2 over samples first .. last-1, on windows growing from the start's own stretch.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: no minimum was found.
    """
    period = 2.0 * np.pi / start.dynamics.w * problem.record.sampling_rate_hz
    length = max(int(start_periods * period), 32)
    prior = weak_prior(problem.model, start)
    state = start
    while problem.first + length < last:
        some = _subsample(length, period, schedule.half_cycles)
        found = _Stage(problem, problem.first + length, some, schedule.digits, prior).minimise(state, schedule.early)
        state = found.state
        wanted = min(schedule.growth, (last - problem.first) / length)
        length = math.ceil(length * _growth(problem, found, length, wanted))
    if schedule.digits < EXACT:
        whole = last - problem.first
        some = _subsample(whole, period, max(schedule.half_cycles, int(schedule.last_share * 2.0 * whole / period)))
        state = _Stage(problem, last, some, schedule.digits, None).minimise(state, schedule.late).state
    final = _Stage(problem, last, ALL_SAMPLES, EXACT, None).minimise(state, schedule.final)
    normal = problem.after(final.before, final.step)
    chi2_sd = math.sqrt(2.0 * problem.record.channels * normal.samples)
    fall = final.before.normal.chi2 - normal.chi2
    if fall < _NEGLIGIBLE_FALL * chi2_sd:
        return Minimum(final.state, final.before.state, normal, final.before.moments, max(fall, 0.0))
    return Minimum(final.state, final.state, normal, final.before.moments)


def _growth(problem: FitProblem, found: _StageEnd, length: int, growth: float) -> float:
    """How much longer the window may become before the phase at its end is uncertain, no more than `growth`.

    An error of w adds to the phase in proportion to time, one of the amplitude as well, one of a loss with its square.
    """
    d, slopes = found.state.dynamics, found.before.moments.slopes
    chain = d.chain(problem.model)
    direction = np.zeros(problem.free.size)
    while growth > 2.0:
        end = (problem.first + growth * length) * problem.record.dt_s
        direction[: chain.shape[0]] = np.array([1.0, end, -growth * slopes[0], *(-(growth**2) * slopes[1:])]) @ chain
        if variance_of(direction, found.before.normal, problem.free) < _SURE_PHASE**2:
            return growth
        growth *= 0.5
    return 2.0


def _subsample(samples: int, period: float, half_cycles: int) -> Subsample:
    """So many half cycles of a window, and of their samples no more than an early pass needs; period: in samples."""
    stride = int(2.0 * samples / (period * half_cycles)) | 1  # odd, so that both directions are seen
    if half_cycles > samples:
        return Subsample(stride)
    most = min(samples / _ENOUGH_SAMPLES, _MOST_LEFT_OUT) / stride, 0.5 * period / _ENOUGH_IN_HALF_CYCLE
    return Subsample(stride, max(1, int(min(most))))


@dataclass(frozen=True)
class _StageEnd:
    """End of a stage: the state, and what was known one negligible step before it."""

    state: FitState
    before: Evaluation
    step: Array


@dataclass
class _Stage:
    """Damped Gauss-Newton on one window."""

    problem: FitProblem
    last: int
    some: Subsample
    digits: float
    prior: Prior | None

    def minimise(self, state: FitState, tolerance: float) -> _StageEnd:
        """Steps until the fall of chi^2 that a step predicts, or what it will leave to the next one, is small.

        Gauss-Newton's error is about the square of its step, taken relative to what the model bends over.
        """
        at = self._evaluate(state)
        damping = 0.0
        for _ in range(_MOST_ITERATIONS):
            step, predicted = solve_step(at.normal, self.problem.free, damping)
            shrink = _shrink(at.state, step, self.last * self.problem.record.dt_s)
            undamped = damping == 0.0 and shrink == 1.0
            if undamped and (predicted < tolerance or self._left(at, step, predicted) < tolerance):
                return _StageEnd(at.state.moved(step), at, step)
            trial = self._try(at.state.moved(shrink * step))
            if trial is not None and _is_better(trial.normal, at.normal):
                at = trial
                damping = 0.1 * damping if damping > 1e-6 else 0.0
            else:
                damping = max(1e-4, 10.0 * damping)
            if damping > 1e8:
                break
        raise NoConvergenceError(f"no minimum after {_MOST_ITERATIONS} iterations")

    def _left(self, at: Evaluation, step: Array, predicted: float) -> float:
        """Upper estimate of the fall of chi^2 that the next step would predict."""
        return _CAUTION * self.problem.bend(at, step, self.last) ** 2 * predicted

    def _try(self, state: FitState) -> Evaluation | None:
        try:
            return self._evaluate(state)
        except LostTrajectoryError:
            return None

    def _evaluate(self, state: FitState) -> Evaluation:
        """With the prior, if there is one."""
        at = self.problem.evaluate(state, self.last, self.some, self.digits)
        return at if self.prior is None else Evaluation(at.state, at.moments, self.prior.added(at.normal, at.state))


def _is_better(trial: NormalEquations, normal: NormalEquations) -> bool:
    """Not worse than rounding, or than the few samples that changed sides where half cycles are left out."""
    slack = 1e-12 if trial.samples == normal.samples else 0.02
    rounding = 1e-6 + ROUNDING * normal.data_chi2
    return trial.chi2 / trial.samples <= (normal.chi2 * (1.0 + slack) + rounding) / normal.samples


def _shrink(state: FitState, step: Array, t_end_s: float) -> float:
    """Largest fraction of a step for which the linearisation can still hold."""
    own = 3 + len(state.dynamics.values)
    excess = max(
        abs(step[0]) / 0.7,
        abs(step[1]) * t_end_s / 2.0,
        abs(step[2]) / (0.4 * abs(state.dynamics.amplitude)),
        state.observation.bend(step[own : own + state.observation.size]),
    )
    return 1.0 if excess <= 1.0 else 1.0 / excess

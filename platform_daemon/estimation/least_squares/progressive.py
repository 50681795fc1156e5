"""The stages of a fit: Gauss-Newton on growing windows, from a few periods to the whole.

The quick schedule looks at some of the half cycles only until the last passes over everything; the careful one looks
at all of them, on windows that double, and is used where the quick one fails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import COARSE, EXACT
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .gauss_newton import FitState, NormalEquations, gauss_newton_step, variance_of
from .problem import ALL_SAMPLES, ROUNDING, Evaluation, FitProblem, Minimum, NoConvergenceError, Subsample

LIMITS = THRESHOLDS.least_squares


@dataclass(frozen=True, kw_only=True)
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


QUICK = FitStages(
    growth=LIMITS.quick_growth,
    early=LIMITS.quick_early_chi2,
    late=LIMITS.quick_late_chi2,
    final=LIMITS.quick_final_chi2,
    half_cycles=LIMITS.quick_half_cycles,
    last_share=LIMITS.quick_last_share,
    digits=COARSE,
)
CAREFUL = FitStages(
    growth=LIMITS.careful_growth,
    early=LIMITS.careful_early_chi2,
    late=LIMITS.careful_early_chi2,
    final=LIMITS.careful_final_chi2,
    half_cycles=1 << 60,  # all
    last_share=1.0,
    digits=EXACT,
)


@dataclass(frozen=True)
class Prior:
    """Gaussian knowledge for windows too short to determine everything: of the amplitude, then of the loss
    coefficients.

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

    Where nothing but the small anharmonicity determines the amplitude, half of the start value is its standard
    deviation.

    Raises:
        NoConvergenceError: an amplitude of 0, about which nothing is known then.
    """
    d = state.dynamics
    names = [c.name for c in model.coefficients]
    sizes = [max(c.typical * d.w**c.power, abs(q)) for c, q in zip(model.coefficients, d.values, strict=True)]
    widths = [LIMITS.prior_width * size for size in sizes]
    # The turning points of an angle determine the losses better than the drift of a harmonic does.
    if model.losses and state.observation.observable == DIPOLE:
        widths[names.index(model.losses[-1])] *= LIMITS.prior_decay_width
    amplitude = np.inf if state.observation.ties_amplitude else LIMITS.prior_amplitude_share * abs(d.amplitude)
    if amplitude == 0.0:
        raise NoConvergenceError("the start values have no amplitude: the motion is not an oscillation")
    return Prior(np.array([d.amplitude, *d.values]), np.array([amplitude, *widths]) ** -2.0)


def fit_progressively(
    problem: FitProblem, start: FitState, *, start_periods: float, last: int, schedule: FitStages = CAREFUL
) -> Minimum:
    """Minimise chi^2 over samples first .. last-1, on windows growing from the start's own stretch.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: no minimum was found.
    """
    period = 2.0 * np.pi / start.dynamics.w * problem.record.sampling_rate_hz
    length = max(int(start_periods * period), LIMITS.first_samples)
    prior = weak_prior(problem.model, start)
    state = start
    while problem.first + length < last:
        some = _subsample(length, period, schedule.half_cycles)
        found = _Stage(
            problem=problem, last=problem.first + length, some=some, digits=schedule.digits, prior=prior
        ).minimise(state, schedule.early)
        state = found.state
        wanted = min(schedule.growth, (last - problem.first) / length)
        length = math.ceil(length * _growth(problem, found, length, wanted))
    if schedule.digits < EXACT:
        whole = last - problem.first
        some = _subsample(whole, period, max(schedule.half_cycles, int(schedule.last_share * 2.0 * whole / period)))
        state = (
            _Stage(problem=problem, last=last, some=some, digits=schedule.digits, prior=None)
            .minimise(state, schedule.late)
            .state
        )
    final = _Stage(problem=problem, last=last, some=ALL_SAMPLES, digits=EXACT, prior=None).minimise(
        state, schedule.final
    )
    normal = problem.after(final.before, final.step)
    chi2_sd = math.sqrt(2.0 * problem.record.channels * normal.samples)
    fall = final.before.normal.chi2 - normal.chi2
    if fall < LIMITS.negligible_fall_sigma * chi2_sd:
        return Minimum(
            state=final.state,
            tabulated=final.before.state,
            normal=normal,
            moments=final.before.moments,
            left=max(fall, 0.0),
        )
    return Minimum(state=final.state, tabulated=final.state, normal=normal, moments=final.before.moments)


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
        if variance_of(direction, found.before.normal, problem.free) < LIMITS.sure_phase_rad**2:
            return growth
        growth *= 0.5
    return 2.0


def _subsample(samples: int, period: float, half_cycles: int) -> Subsample:
    """So many half cycles of a window, and of their samples no more than an early pass needs; period: in samples."""
    stride = int(2.0 * samples / (period * half_cycles)) | 1  # odd, so that both directions are seen
    if half_cycles > samples:
        return Subsample(stride)
    most = (
        min(samples / LIMITS.early_samples, LIMITS.early_stride) / stride,
        0.5 * period / LIMITS.early_half_cycle_samples,
    )
    return Subsample(stride, max(1, int(min(most))))


@dataclass(frozen=True)
class _StageEnd:
    """End of a stage: the state, and what was known one negligible step before it."""

    state: FitState
    before: Evaluation
    step: Array


@dataclass(kw_only=True)
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
        for _ in range(LIMITS.most_iterations):
            step, predicted = gauss_newton_step(at.normal, self.problem.free, damping)
            shrink = _shrink(at.state, step, self.last * self.problem.record.dt_s)
            undamped = damping == 0.0 and shrink == 1.0
            if undamped and (predicted < tolerance or self._left(at, step, predicted) < tolerance):
                return _StageEnd(at.state.moved(step), at, step)
            trial = self._try(at.state.moved(shrink * step))
            if trial is not None and _is_better(trial.normal, at.normal):
                at = trial
                damping = LIMITS.damping_fall * damping if damping > LIMITS.no_damping else 0.0
            else:
                damping = max(LIMITS.least_damping, LIMITS.damping_factor * damping)
            if damping > LIMITS.most_damping:
                break
        raise NoConvergenceError(f"no minimum after {LIMITS.most_iterations} iterations")

    def _left(self, at: Evaluation, step: Array, predicted: float) -> float:
        """Upper estimate of the fall of chi^2 that the next step would predict."""
        return LIMITS.caution * self.problem.bend(at, step, self.last) ** 2 * predicted

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
    slack = LIMITS.worse_share if trial.samples == normal.samples else LIMITS.worse_subsample_share
    rounding = LIMITS.worse_chi2 + ROUNDING * normal.data_chi2
    return trial.chi2 / trial.samples <= (normal.chi2 * (1.0 + slack) + rounding) / normal.samples


def _shrink(state: FitState, step: Array, t_end_s: float) -> float:
    """Largest fraction of a step for which the linearisation can still hold."""
    own = 3 + len(state.dynamics.values)
    excess = max(
        abs(step[0]) / LIMITS.step_phase_rad,
        abs(step[1]) * t_end_s / LIMITS.step_frequency_rad,
        abs(step[2]) / (LIMITS.step_amplitude_share * abs(state.dynamics.amplitude)),
        state.observation.bend(step[own : own + state.observation.size]),
    )
    return 1.0 if excess <= 1.0 else 1.0 / excess

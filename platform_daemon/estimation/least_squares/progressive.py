"""The fit's schedule: Gauss-Newton on growing windows, from a few periods to the whole.

The quick schedule looks at some of the half cycles only until the last passes over everything; the careful one looks
at all of them, on windows that double, and takes over where the quick one fails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..moments.workspace import Moments, Workspace
from ..numerics.arrays import Array
from ..numerics.chebyshev import COARSE, EXACT
from ..physics.models import RingDownModel
from ..physics.trajectory.basis_functions import DIPOLE
from ..physics.trajectory.direct import LostTrajectoryError
from ..record import RingDownRecord
from .constraints import Constraints
from .gauss_newton import (
    FitState,
    NormalEquations,
    after_step,
    normal_equations,
    solve_step,
    variance_of,
    with_best_gains,
)

_MOST_ITERATIONS = 30
_MOST_PASSES = 250
_SURE_PHASE = 0.05  # rad
_CAUTION = 4.0
_ROUNDING = 1e-9  # of the data's own chi^2: the digits of the trajectory, and those lost in the difference
_LOST = 0.1  # of the standard deviation of chi^2: so much rounding may take
_NEGLIGIBLE_FALL = 0.2  # of chi^2, in its standard deviations
_CHUNK = 4096  # samples whose residual is in memory at once
_ENOUGH_SAMPLES = 3000  # for an early pass
_ENOUGH_IN_HALF_CYCLE = 24
_MOST_LEFT_OUT = 15  # an early pass looks at no less than one in so many samples
_PRIOR_WIDTH = 3.0  # of a coefficient's typical size
_PRIOR_AMPLITUDE = 0.5  # of the start value


class NoConvergenceError(ArithmeticError):
    """Gauss-Newton found no way down."""


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
class Subsample:
    """Which samples of a window take part: those of every so many-th half cycle (odd), of these every so many-th."""

    half_cycle: int = 1
    sample: int = 1


ALL_SAMPLES = Subsample()


@dataclass
class FitProblem:
    """A record, a model and its noise; counts the passes over the samples.

    doubts: warnings about the minimum that was found.
    """

    record: RingDownRecord
    model: RingDownModel
    noise_sd: Array
    free: np.ndarray
    first: int
    knowledge: Constraints = field(default_factory=Constraints)
    passes: int = 0
    doubts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        self.workspace = Workspace(self.model)
        self._weights = 1.0 / (self.noise_sd * self.noise_sd)
        self._thinned = {1: self.record.samples}

    def evaluate(self, state: FitState, last: int, some: Subsample = ALL_SAMPLES, digits: float = EXACT) -> Evaluation:
        """Normal equations over samples first .. last-1, or over some of them; one pass.

        The state comes back with its free gains, if it has any, put at their best for this trajectory.

        Raises:
            LostTrajectoryError: the state does not oscillate.
        """
        self.passes += 1
        if self.passes > _MOST_PASSES:
            raise NoConvergenceError(f"no minimum within {_MOST_PASSES} passes over the samples")
        every = some.sample
        if every not in self._thinned:
            self._thinned[every] = np.ascontiguousarray(self.record.samples[:, ::every])
        moments = self.workspace.moments(
            state.dynamics, self._thinned[every], -(-self.first // every), -(-last // every),
            every * self.record.dt_s, state.observation.observable, some.half_cycle, digits,
        )  # fmt: skip
        state = with_best_gains(state, moments)
        normal = self.knowledge.added(normal_equations(self.model, state, moments, self._weights), state)
        return Evaluation(state, moments, normal)

    def _squares(self, state: FitState, last: int) -> Array:
        """Sum of the squared residual by channel, (channels,), sample by sample: moments lose digits that this keeps.

        Raises:
            LostTrajectoryError: the state does not oscillate.
        """
        d, seen, y = state.dynamics, state.observation, self.record.samples
        motion = self.workspace.block_means(d, self.first, last - self.first, 1, self.record.dt_s, seen.observable, 0.0)
        total = np.zeros(y.shape[0])
        for begin in range(self.first, last, _CHUNK):
            here = slice(begin, min(begin + _CHUNK, last))
            model = seen.gains(d.w) @ motion[:, here.start - self.first : here.stop - self.first]
            total += np.sum((y[:, here] - model - state.offsets[:, None]) ** 2, axis=1)
        return total

    def bend(self, at: Evaluation, step: Array, last: int) -> float:
        """A step relative to what the model bends over: phase at both ends in rad, amplitude, gains in themselves."""
        d, seen = at.state.dynamics, at.state.observation
        k = 3 + len(d.values)
        begin, by_w, by_amplitude = step[:3].tolist()
        inner = d.chain(self.model)[2:] @ step[:k]
        end = begin + by_w * last * self.record.dt_s - float(at.moments.slopes @ inner)
        return max(abs(begin), abs(end), abs(by_amplitude / d.amplitude), seen.bend(step[k : k + seen.size]))

    def after(self, at: Evaluation, step: Array) -> NormalEquations:
        """The normal equations of all samples with the residual that a small step leaves."""
        normal = after_step(at.normal, self.model, at.state, at.moments, step)
        chance = math.sqrt(2.0 * self.record.channels * normal.samples)
        if self.model.time_dependent or _ROUNDING * normal.data_chi2 < _LOST * chance:
            return normal
        state = at.state.moved(step)
        if state.dynamics.theta < 0.0:
            return normal  # the tables know nothing of time, nor of what was before their anchor
        squares = self._squares(state, self.first + normal.samples)
        chi2 = squares / self.noise_sd**2
        return replace(normal, chi2=float(chi2.sum()), chi2_by_channel=chi2, squares_by_channel=squares)


@dataclass(frozen=True)
class Evaluation:
    """A state, what the samples say about it, and the resulting normal equations."""

    state: FitState
    moments: Moments
    normal: NormalEquations


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


@dataclass(frozen=True)
class Minimum:
    """The minimum, with its normal equations; the moments of one small step before it.

    tabulated: a state as good as the minimum, the one before if the last step was negligible: its tables exist.
    left: chi^2 of the tabulated state above that of the minimum.
    """

    state: FitState
    tabulated: FitState
    normal: NormalEquations
    moments: Moments
    left: float = 0.0


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
    rounding = 1e-6 + _ROUNDING * normal.data_chi2
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

"""What a fit minimises: chi^2 of a record under a model, its normal equations, and the minimum it leads to."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from platform_daemon.estimation.moments.workspace import Moments, Workspace
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import EXACT
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

from .constraints import Constraints
from .gauss_newton import FitState, NormalEquations, after_step, normal_equations, with_best_gains

LIMITS = THRESHOLDS.least_squares
ROUNDING = LIMITS.rounding_share


class NoConvergenceError(ArithmeticError):
    """Gauss-Newton found no way down."""


@dataclass(frozen=True)
class Subsample:
    """Which samples of a window take part: those of every so many-th half cycle (odd), of these every so many-th."""

    half_cycle: int = 1
    sample: int = 1


ALL_SAMPLES = Subsample()


@dataclass(frozen=True)
class Evaluation:
    """A state, what the samples say about it, and the resulting normal equations."""

    state: FitState
    moments: Moments
    normal: NormalEquations


@dataclass(frozen=True, kw_only=True)
class Minimum:
    """The minimum, with its normal equations; the moments of one small step before it.

    tabulated: a state as good as the minimum, the one before if the last step was negligible: its tables exist.
    left: chi^2 of the tabulated state above that of the minimum.
    sd: (channels, 2) standard deviations that odd and even harmonics were weighted by; None: those of the problem.
    """

    state: FitState
    tabulated: FitState
    normal: NormalEquations
    moments: Moments
    left: float = 0.0
    sd: Array | None = None


@dataclass(kw_only=True)
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
        if self.passes > LIMITS.most_passes:
            raise NoConvergenceError(f"no minimum within {LIMITS.most_passes} passes over the samples")
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
        motion = self.workspace.block_means(
            d,
            begin=self.first,
            blocks=last - self.first,
            block=1,
            dt_s=self.record.dt_s,
            observable=seen.observable,
            accuracy=0.0,
        )
        total = np.zeros(y.shape[0])
        for begin in range(self.first, last, LIMITS.residual_chunk_samples):
            here = slice(begin, min(begin + LIMITS.residual_chunk_samples, last))
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
        if self.model.time_dependent or ROUNDING * normal.data_chi2 < LIMITS.lost_sigma * chance:
            return normal
        state = at.state.moved(step)
        if state.dynamics.theta < 0.0:
            return normal  # the tables know nothing of time, nor of what was before their anchor
        squares = self._squares(state, self.first + normal.samples)
        chi2 = squares / self.noise_sd**2
        return replace(normal, chi2=float(chi2.sum()), chi2_by_channel=chi2, squares_by_channel=squares)

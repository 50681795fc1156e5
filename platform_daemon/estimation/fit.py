"""The fit of one ring-down, from raw samples to parameters with their errors."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .growing import CAREFUL, QUICK, Fitted, NoConvergenceError, Problem, fit_growing
from .judgement import (
    POOR_CHI2,
    doubts,
    is_suspect,
    refuse_unexplained,
    refuse_untrustworthy,
    refuse_wrong_variant,
)
from .knowledge import free_mask, held, knowledge_of, refuse_out_of_bounds, with_fixed
from .models import RingDownModel, model_named, rivals_of
from .noise import NoiseModel, estimate_noise
from .publish import by_convention, publish
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .result import FitResult, FittedModel
from .screening import refuse_few_periods, screen
from .start import Start, find_start, observes_dipole
from .start_label import NoLabelError
from .trajectory import LostTrajectoryError
from .weighting import weighted_by_harmonic
from .windows import SampleRange, Window, check_window, select_window

_SHORT_PERIODS = 12.0
_FAILURES = (NoConvergenceError, LostTrajectoryError, NoLabelError, np.linalg.LinAlgError)


def fit_ring_down(
    record: RingDownRecord,
    variant: str | RingDownModel,
    window: Window = "d30",
    *,
    noise: NoiseModel | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a declared model to a ring-down; start values come from the data.

    Args:
        record: RX samples: dm/dt, volts or angle.
        variant: "thread", "jewel" or another declared model (models.py) by name, or any model itself.
        window: "n50" (0.24 s), "d30" (until 30 % of the maximum is left) or seconds.
        noise: measured elsewhere; None: from the record itself.
        fixed: values of f_nat_hz, m_r_am2 or loss coefficients that are not to be fitted.

    Returns:
        A FitResult; unusable data give verdict "refused" with a reason, never an exception.

    Raises:
        ValueError: an unknown variant or window, or a parameter that cannot be fixed (mistakes of the
            caller, not of the data).
    """
    began = time.perf_counter()
    model = model_named(variant) if isinstance(variant, str) else variant
    check_window(window)
    values = held(model, fixed, dipole=observes_dipole(record, model))
    noise_seconds = 0.0
    try:
        task = _task(record, window, noise, values)
        noise_seconds = task.noise_seconds
        result = _fit(task, model)
    except RefusedError as refused:
        result = FitResult("refused", reason=str(refused))
    seconds = time.perf_counter() - began - noise_seconds
    return replace(result, seconds=seconds, noise_seconds=noise_seconds)


@dataclass(frozen=True)
class _Task:
    """What is to be fitted, whichever model does it."""

    record: RingDownRecord
    noise: NoiseModel
    noise_sd: np.ndarray
    chosen: SampleRange
    frequency_hz: float
    fixed: Mapping[str, float]
    noise_seconds: float

    @property
    def samples(self) -> int:
        """Samples per channel in the window."""
        return self.chosen.last - self.chosen.first

    @property
    def periods(self) -> float:
        """Periods in the window."""
        return self.samples * self.record.dt_s * self.frequency_hz


def _task(record: RingDownRecord, window: Window, noise: NoiseModel | None, fixed: Mapping[str, float]) -> _Task:
    """Screen the record, measure its noise, choose the samples."""
    line = screen(record)
    began = time.perf_counter()
    noise = estimate_noise(record) if noise is None else noise
    noise_seconds = time.perf_counter() - began
    sd = _usable_sd(noise, record)
    chosen = select_window(record, window, line.frequency_hz, sd)
    if chosen.last <= chosen.first:
        raise RefusedError(Refusal.TOO_SHORT, "the window ends before the valid samples begin")
    task = _Task(record, noise, sd, chosen, line.frequency_hz, fixed, noise_seconds)
    refuse_few_periods(task.samples * record.dt_s, line.frequency_hz)
    return task


def _fit(task: _Task, model: RingDownModel) -> FitResult:
    """Fit, compare with richer models if the result is suspect, judge."""
    problem, best = _solve(task, model)
    chi2 = best.normal.chi2 / _degrees(task, problem)
    if is_suspect(chi2):
        for other in rivals_of(model) if task.record.quantity != "angle" else ():
            try:
                other_problem, other_best = _solve(task, other)
            except RefusedError:
                continue
            other_chi2 = other_best.normal.chi2 / _degrees(task, other_problem)
            refuse_wrong_variant(model.name, chi2, other.name, other_chi2)
    return _judged(task, problem, best)


def _degrees(task: _Task, problem: Problem) -> int:
    """Degrees of freedom of the residual."""
    return task.record.channels * task.samples - int(problem.free.sum())


def _solve(task: _Task, model: RingDownModel) -> tuple[Problem, Fitted]:
    """Minimise chi^2 from start values found in the data."""
    record, chosen = task.record, task.chosen
    start = find_start(record, model, chosen.first, chosen.last, task.frequency_hz, task.noise_sd)
    free = free_mask(model, start.state(start.amplitudes[0]).size, task.fixed)
    knowledge = knowledge_of(model, task.fixed, dipole=observes_dipole(record, model))
    problem = Problem(record, model, task.noise_sd, free, chosen.first, knowledge)
    try:
        return problem, _weighted(problem, _best_fit(problem, start, task), task)
    except RefusedError as refused:
        if refused.code is Refusal.NO_CONVERGENCE and task.periods < _SHORT_PERIODS:
            raise RefusedError(Refusal.TOO_SHORT, f"no minimum found in {task.periods:.1f} periods") from refused
        raise


def _weighted(problem: Problem, best: Fitted, task: _Task) -> Fitted:
    """The minimum with every harmonic weighted by the noise that stands there."""
    try:
        return weighted_by_harmonic(problem, best, task.chosen.last, task.noise, task.frequency_hz)
    except _FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error


def _usable_sd(noise: NoiseModel, record: RingDownRecord) -> np.ndarray:
    """Standard deviations (channels,), kept above rounding so that noise-free records can be fitted."""
    sd = np.asarray(noise.sd, dtype=np.float64)
    if sd.shape != (record.channels,) or not np.all(np.isfinite(sd)) or np.any(sd < 0.0):
        raise ValueError(f"noise.sd must be {record.channels} finite numbers >= 0, not {sd!r}")
    # A thousand samples, evenly spread, know the size of the signal well enough.
    some = record.valid[:, :: max(1, record.valid.shape[1] // 1000)]
    return np.maximum(sd, 1e-9 * float(np.sqrt(np.mean(some**2))))


def _best_fit(problem: Problem, start: Start, task: _Task) -> Fitted:
    """Quickly from the most trusted start; carefully, and from the others, only if that explains the record badly."""
    best: Fitted | None = None
    dof = _degrees(task, problem)
    failure = "no start value led anywhere"
    for amplitude, schedule in [(start.amplitudes[0], QUICK), *((a, CAREFUL) for a in start.amplitudes)]:
        state = by_convention(with_fixed(start.state(amplitude), problem.model, task.fixed))
        try:
            fitted = fit_growing(problem, state, start.periods, task.chosen.last, schedule)
        except _FAILURES as error:
            failure = str(error)
            continue
        if best is None or fitted.normal.chi2 < best.normal.chi2:
            best = fitted
        if best.normal.chi2 < POOR_CHI2 * dof:
            break
    if best is None:
        raise RefusedError(Refusal.NO_CONVERGENCE, failure)
    return best


def _judged(task: _Task, problem: Problem, best: Fitted) -> FitResult:
    """Quality figures and the verdict."""
    record, model, chosen = task.record, problem.model, task.chosen
    squares = float(best.normal.squares_by_channel.sum())
    energy = float(best.moments.energy.sum())
    sums = best.moments.products[:, -1]
    r2 = 1.0 - squares / (energy - float(np.sum(sums**2)) / task.samples)
    nrmse = math.sqrt(squares / energy)
    dof = _degrees(task, problem)
    chi2 = best.normal.chi2 / dof
    by_channel = tuple(float(c) * record.channels / dof for c in best.normal.chi2_by_channel)
    refuse_unexplained(model.name, r2, chi2)
    state = by_convention(best.state)
    try:
        # The start already obeyed the convention; only a fit that crossed over needs its derivatives anew.
        normal = best.normal if state is best.state else problem.evaluate(state, chosen.last).normal
        public = publish(model, state, normal, problem.free)
    except _FAILURES as error:
        raise RefusedError(Refusal.OUT_OF_RANGE, str(error)) from error
    refuse_untrustworthy(model, public)
    refuse_out_of_bounds(model, public, state.dynamics.amplitude)
    return FitResult(
        verdict="good",
        warnings=doubts(model, public, chi2, task.samples * record.dt_s, task.periods),
        notes=(*chosen.notes, *problem.knowledge.notes),
        parameters=public.parameters,
        covariance=public.covariance,
        covariance_names=public.names,
        r2=r2,
        nrmse=nrmse,
        chi2_per_dof=chi2,
        chi2_per_dof_by_channel=by_channel,
        window_s=chosen.last * record.dt_s,
        samples=task.samples,
        iterations=problem.passes,
        noise_source=task.noise.source,
        fitted=FittedModel(model, state),
    )

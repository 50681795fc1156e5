"""The fit of one ring-down, from raw samples to parameters with their errors."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .ambiguity import ambiguity
from .beat import find_beat
from .companion import Companion, find_companion
from .disturbances import without_disturbances
from .gauss_newton import FitState
from .growing import CAREFUL, QUICK, Fitted, NoConvergenceError, Problem, fit_growing
from .hints import hint_notes, hinted, needed_hints
from .judgement import (
    POOR_CHI2,
    Explanation,
    compare,
    doubts,
    is_suspect,
    is_unexplained,
    refuse_faint,
    refuse_unexplained,
    refuse_untrustworthy,
)
from .knowledge import free_mask, held, knowledge_of, refuse_out_of_bounds, with_fixed
from .leftover import leftover_of
from .losses import tangled_losses
from .misfit import is_worth_a_search, misfit_warnings, refuse_misfit
from .models import RingDownModel, model_named, rivals_of
from .noise import NoiseModel, estimate_noise
from .periods import FEW_PERIODS, counted_periods
from .publish import by_convention, publish
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .residual import Residual, residual_of
from .result import FitResult, FittedModel
from .screening import few_at_full_scale, refuse_few_periods, screen
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
    hints: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a declared model to a ring-down; start values come from the data.

    Args:
        record: RX samples: dm/dt, volts or angle.
        variant: "thread", "jewel" or another declared model (models.py) by name, or any model itself.
        window: "n50" (0.24 s), "d30" (until 30 % of the maximum is left) or seconds.
        noise: measured elsewhere; None: from the record itself.
        fixed: values of f_nat_hz, m_r_am2 or loss coefficients that are not to be fitted.
        hints: values at which losses are held only if the window cannot tell them from others (hints.py).

    Returns:
        A FitResult; unusable data give verdict "refused" with a reason, never an exception.

    Raises:
        ValueError: an unknown variant or window, or a parameter that cannot be fixed (mistakes of the
            caller, not of the data).
    """
    began = time.perf_counter()
    model = model_named(variant) if isinstance(variant, str) else variant
    check_window(window)
    dipole = observes_dipole(record, model)
    values = held(model, fixed, dipole=dipole)
    known = hinted(model, hints, values, dipole=dipole)
    noise_seconds = 0.0
    try:
        task = _task(record, window, noise, values)
        noise_seconds = task.noise_seconds
        result = _fit_or_refuse(task, model)
        needed = needed_hints(result, known)
        if needed:
            result = _fit_or_refuse(replace(task, fixed={**values, **needed}), model)
            result = replace(result, notes=(*result.notes, *hint_notes(needed)))
    except RefusedError as refused:
        result = _refused(refused)
    seconds = time.perf_counter() - began - noise_seconds
    return replace(result, seconds=seconds, noise_seconds=noise_seconds)


def solve_ring_down(
    record: RingDownRecord, model: RingDownModel, window: Window, *, noise: NoiseModel | None = None
) -> FitState:
    """The state that explains a ring-down best, however badly: nothing is judged, nothing taken out of the record.

    Raises:
        RefusedError: the record cannot be used, or no minimum was found.
    """
    return _solve(_task(record, window, noise, {}), model)[1].state


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
    doubts: tuple[str, ...] = ()

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
    if task.periods < FEW_PERIODS and record.quantity != "angle":
        seen = record.samples[:, chosen.first : chosen.last]
        counted = counted_periods(seen, record.dt_s, line.frequency_hz)
        task = replace(task, frequency_hz=counted / (task.samples * record.dt_s))
    refuse_few_periods(task.samples * record.dt_s, task.frequency_hz)
    return task


def _refused(refused: RefusedError) -> FitResult:
    """The result that says why there is none."""
    return FitResult("refused", reason=str(refused), code=refused.code)


def _fit_or_refuse(task: _Task, model: RingDownModel) -> FitResult:
    """The fit of a task, good or refused."""
    try:
        return _fit(task, model)
    except RefusedError as refused:
        return _refused(refused)


def _fit(task: _Task, model: RingDownModel) -> FitResult:
    """Fit, compare with rival models if the result is suspect, judge."""
    problem, best = _solve(task, model)
    residual = _residual(task, problem, best)
    task = replace(task, doubts=(*problem.doubts, *few_at_full_scale(task.record)))
    task, problem, best, residual = _undisturbed(task, problem, best, residual)
    dof = _degrees(task, problem)
    doubtful = _compared(task, problem, best) if is_suspect(best.normal.chi2 / dof, dof) else ()
    result = _judged(task, problem, best, residual)
    return replace(result, warnings=(*result.warnings, *doubtful))


def _compared(task: _Task, problem: Problem, best: Fitted) -> tuple[str, ...]:
    """Warnings from the rivals of a model, which may also refuse it."""
    warnings: tuple[str, ...] = ()
    for other in rivals_of(problem.model) if task.record.quantity != "angle" else ():
        try:
            other_problem, other_best = _solve(task, other)
        except RefusedError:
            continue
        dof = _degrees(task, other_problem)
        warnings += compare(_explanation(problem, best, dof), _explanation(other_problem, other_best, dof), dof)
    return warnings


def _explanation(problem: Problem, best: Fitted, dof: int) -> Explanation:
    """A fit as its rivals see it."""
    model = problem.model
    names = [c.name for c in model.coefficients]
    values = dict(zip(names, best.state.dynamics.values, strict=True))
    return Explanation(model.name, best.normal.chi2 / dof, {name: values[name] for name in model.losses})


def _undisturbed(
    task: _Task, problem: Problem, best: Fitted, residual: Residual
) -> tuple[_Task, Problem, Fitted, Residual]:
    """The task freed from hum and drift that the residual shows, the fit that is joint with them, what it leaves."""
    if task.record.quantity == "angle":
        return task, problem, best, residual
    try:
        beside = without_disturbances(problem, best, residual, task.chosen, task.noise, task.frequency_hz)
    except _FAILURES:
        beside = None  # the verdict on the residual says what is wrong with it
    if beside is None:
        return task, problem, best, residual
    chosen = replace(task.chosen, notes=(*task.chosen.notes, *beside.notes))
    problem = beside.problem
    task = replace(task, record=problem.record, noise=beside.noise, noise_sd=problem.noise_sd, chosen=chosen)
    return task, problem, beside.fitted, _residual(task, problem, beside.fitted)


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
    return np.maximum(sd, 1e-9 * math.sqrt(float(np.einsum("ij,ij", some, some)) / some.size))


def _best_fit(problem: Problem, start: Start, task: _Task) -> Fitted:
    """Quickly from the most trusted start; carefully, and from the others, only if that explains the record badly."""
    found: list[Fitted] = []
    dof = _degrees(task, problem)
    failure = "no start value led anywhere"
    for amplitude, schedule in [(start.amplitudes[0], QUICK), *((a, CAREFUL) for a in start.amplitudes)]:
        state = by_convention(with_fixed(start.state(amplitude), problem.model, task.fixed))
        try:
            found.append(fit_growing(problem, state, start.periods, task.chosen.last, schedule))
        except _FAILURES as error:
            failure = str(error)
            continue
        if found[-1].normal.chi2 < POOR_CHI2 * dof:
            break
    if not found:
        first = by_convention(with_fixed(start.state(start.amplitudes[0]), problem.model, task.fixed))
        _refuse_faint(task, problem, first)
        _refuse_beat(task)
        raise RefusedError(Refusal.NO_CONVERGENCE, failure)
    problem.doubts = ambiguity(found, problem.free, dof)
    return min(found, key=lambda fitted: fitted.normal.chi2)


def _refuse_faint(task: _Task, problem: Problem, state: FitState) -> None:
    """A signal too weak for its size to be told, at these start values, as the reason why a fit went wrong."""
    try:
        normal = problem.evaluate(state, task.chosen.last).normal
        public = publish(problem.model, state, normal, problem.free)
    except _FAILURES:
        return
    refuse_faint(public)


def _refuse_beat(task: _Task) -> None:
    """Two resonators as the reason why a fit went wrong; a window may end where they first cancel each other."""
    record = task.record
    if record.quantity == "angle":
        return
    beat = find_beat(record, record.valid_from, record.end, task.frequency_hz, task.noise_sd)
    if beat is not None:
        one, other = beat.frequencies_hz
        seen = f"{one:.6g} Hz and {other:.6g} Hz, the second with {100.0 * beat.ratio:.2g} % of the first's size"
        raise RefusedError(Refusal.TWO_RESONATORS, seen)


def _residual(task: _Task, problem: Problem, best: Fitted) -> Residual:
    """What the fit leaves over."""
    try:
        return residual_of(task.record, problem.workspace, best.tabulated, task.chosen, task.noise, task.noise_sd)
    except _FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error


def _second_oscillation(task: _Task, problem: Problem, best: Fitted, residual: Residual) -> Companion | None:
    """What else oscillates in the record, if the residual is worth a search."""
    if task.record.quantity == "angle" or not is_worth_a_search(residual):
        return None
    args = problem.model, best.tabulated, problem.free, task.chosen.first, task.record.dt_s
    try:
        return find_companion(leftover_of(residual, *args))
    except _FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error


def _judged(task: _Task, problem: Problem, best: Fitted, residual: Residual) -> FitResult:
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
    if is_unexplained(r2, chi2):
        _refuse_beat(task)
    refuse_unexplained(model.name, r2, chi2)
    second = _second_oscillation(task, problem, best, residual)
    if record.quantity != "angle":
        refuse_misfit(model.name, task.frequency_hz, residual, second)
    state = by_convention(best.state)
    try:
        # The start already obeyed the convention; only a fit that crossed over needs its derivatives anew.
        normal = best.normal if state is best.state else problem.evaluate(state, chosen.last).normal
        public = publish(model, state, normal, problem.free)
    except _FAILURES as error:
        raise RefusedError(Refusal.OUT_OF_RANGE, str(error)) from error
    refuse_untrustworthy(model, public)
    refuse_out_of_bounds(model, public, state.dynamics.amplitude)
    tangle = tangled_losses(model, public)
    return FitResult(
        verdict="good",
        warnings=(
            *misfit_warnings(residual, chi2, second),
            *task.doubts,
            *doubts(model, public, tangle, task.samples * record.dt_s, task.periods),
        ),
        notes=(*chosen.notes, *problem.knowledge.notes),
        parameters=public.parameters,
        covariance=public.covariance,
        covariance_names=public.names,
        r2=r2,
        nrmse=nrmse,
        chi2_per_dof=chi2,
        chi2_per_dof_by_channel=by_channel,
        whiteness_by_channel=tuple(residual.flatness.tolist()),
        condition=public.condition,
        inseparable=() if tangle is None else tangle.names,
        window_s=chosen.last * record.dt_s,
        samples=task.samples,
        iterations=problem.passes,
        noise_source=task.noise.source,
        fitted=FittedModel(model, state),
    )

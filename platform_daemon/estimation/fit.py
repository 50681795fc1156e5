"""The fit of one ring-down, from raw samples to parameters with their errors."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from .goodness_of_fit.acceptance import is_much_or_hidden
from .goodness_of_fit.envelope_lack_of_fit import envelope_lack_of_fit_sigma
from .goodness_of_fit.failure_cause import refuse_by_cause, refuse_lost_contact
from .goodness_of_fit.held_losses import held_loss_notes, holdable_losses, loss_to_hold
from .goodness_of_fit.interference import without_interference
from .goodness_of_fit.model_comparison import Comparison, ModelSummary, compare, refuse_decided
from .goodness_of_fit.residual import Residual
from .goodness_of_fit.thresholds import LIMITS
from .goodness_of_fit.verdict import assess_fit, public_parameters, residual_left
from .initial_guess.guess import observes_dipole
from .least_squares.constraints import held
from .least_squares.problem import FitProblem, Minimum
from .noise.model import OWN, OWN_FLOOR, OWN_RESIDUAL, NoiseModel
from .numerics.blas_threads import one_thread_for_products
from .physics.models import RingDownModel, alternatives_of, model_named
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .result import FitResult
from .screening.screening import few_at_full_scale
from .screening.windows import Window, check_window
from .solve import FAILURES, find_minimum
from .task import Task, task_of


def fit_ring_down(
    record: RingDownRecord,
    variant: str | RingDownModel,
    window: Window = "d30",
    *,
    noise: NoiseModel | None = None,
    fixed: Mapping[str, float] | None = None,
    hold_if_inseparable: Mapping[str, float] | None = None,
    hints: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a declared model to a ring-down; start values come from the data.

    Args:
        record: RX samples: dm/dt, volts or angle.
        variant: "thread", "jewel" or another declared model (models.py) by name, or any model itself.
        window: "n50" (0.24 s), "d30" (until 30 % of the maximum is left) or seconds.
        noise: measured elsewhere; None: from the record itself.
        fixed: values of f_nat_hz, m_r_am2 or loss coefficients that are not to be fitted.
        hold_if_inseparable: values at which losses are held only if the window cannot tell them from others.
        hints: the former name of hold_if_inseparable; deprecated.

    Returns:
        A FitResult; unusable data give verdict "refused" with a reason, never an exception.

    Raises:
        ValueError: an unknown variant or window, or a parameter that cannot be fixed (mistakes of the
            caller, not of the data).
    """
    one_thread_for_products()
    began = time.perf_counter()
    model = model_named(variant) if isinstance(variant, str) else variant
    check_window(window)
    dipole = observes_dipole(record, model)
    values = held(model, fixed, dipole=dipole)
    known = holdable_losses(model, _by_new_name(hold_if_inseparable, hints), values, dipole=dipole)
    noise_seconds = 0.0
    try:
        task = task_of(record, window, noise, values)
        noise_seconds = task.noise_seconds
        result = _fit_or_refuse(task, model)
        needed = loss_to_hold(result, known)
        if needed:
            result = _fit_or_refuse(replace(task, fixed={**values, **needed}), model)
            result = replace(result, notes=(*result.notes, *held_loss_notes(needed)))
    except RefusedError as refused:
        result = FitResult.refused(refused)
    seconds = time.perf_counter() - began - noise_seconds
    return replace(result, seconds=seconds, noise_seconds=noise_seconds)


def _by_new_name(
    hold_if_inseparable: Mapping[str, float] | None, hints: Mapping[str, float] | None
) -> Mapping[str, float] | None:
    """Values by the parameter's name or by its former one.  Raises ValueError for both."""
    if hints is None:
        return hold_if_inseparable
    if hold_if_inseparable is not None:
        raise ValueError("hints is the former name of hold_if_inseparable: give one of them")
    warnings.warn("hints is now called hold_if_inseparable", DeprecationWarning, stacklevel=3)
    return hints


def _fit_or_refuse(task: Task, model: RingDownModel) -> FitResult:
    """The fit of a task, good or refused."""
    try:
        return _fit(task, model)
    except RefusedError as refused:
        try:
            refuse_lost_contact(task, model, refused)
        except RefusedError as named:
            return FitResult.refused(named)
        return FitResult.refused(refused)


def _fit(task: Task, model: RingDownModel) -> FitResult:
    """Fit, compare with rival models if the result is suspect or could be, judge."""
    try:
        problem, best = find_minimum(task, model)
    except RefusedError as refused:
        if refused.code is Refusal.NO_CONVERGENCE:
            refuse_by_cause(task, model)
        raise
    residual = residual_left(task, problem, best)
    if task.record.quantity == "angle" and task.noise.source == OWN:
        task, problem, best, residual = _at_seen_noise(task, problem, best, residual)
    doubts = (*problem.doubts, *few_at_full_scale(task.record))
    task = replace(task, doubts=doubts) if doubts else task
    given = task
    task, problem, best, residual = _without_interference(task, problem, best, residual)
    better = _compared(given, problem, best, residual)
    refuse_decided([other for other in better if other.complete])
    result = assess_fit(task, problem, best, residual)
    # What leaves a misfit itself can be right only where the residual does not show another cause.
    refuse_decided(better)
    seen = tuple(f"other_variant: {other.seen}" for other in better)
    return replace(result, warnings=result.warnings + seen) if seen else result


def _at_seen_noise(
    task: Task, problem: FitProblem, best: Minimum, residual: Residual
) -> tuple[Task, FitProblem, Minimum, Residual]:
    """The fit of an angle at the noise that its residual shows, for beside few harmonics it is seen too dimly.

    The residual's own size where it is nothing but noise; else what of it reaches above the harmonics.
    """
    if not residual.coloured:
        task = task.at_level(math.sqrt(best.normal.chi2 / task.degrees(problem)), OWN_RESIDUAL)
        problem, best = find_minimum(task, problem.model)
        return task, problem, best, residual_left(task, problem, best)
    if residual.floor is None:
        return task, problem, best, residual
    task = task.with_white_noise(residual.floor.sd(task.record.sampling_rate_hz), OWN_FLOOR)
    problem = replace(problem, noise_sd=task.noise_sd)
    at = problem.evaluate(best.state, task.chosen.last)
    best = replace(best, state=at.state, normal=at.normal, moments=at.moments)
    return task, problem, best, residual_left(task, problem, best)


def _compared(task: Task, problem: FitProblem, best: Minimum, residual: Residual) -> list[Comparison]:
    """The alternatives to a model that explain the record better, where that could be.

    Every one is fitted jointly with the hum and the drift that it needs itself: a wrong model takes its own misfit
    for such.
    """
    alternatives = alternatives_of(problem.model, task.record.quantity)
    alternatives = tuple(other for other in alternatives if _can_matter(task, problem, best, residual, other))
    if not alternatives:
        return []
    try:
        own = _model_summary(task, problem, best, residual)
    except RefusedError:
        return []  # it will be refused for that
    theirs = sorted(_alternative_summaries(task, alternatives), key=lambda other: other.chi2_per_dof)
    found = [compare(own, other, task.degrees(problem)) for other in theirs]
    return [comparison for comparison in found if comparison is not None]


def _can_matter(task: Task, problem: FitProblem, best: Minimum, residual: Residual, other: RingDownModel) -> bool:
    """A law with as many coefficients is always asked: what one leaves of another's record is little."""
    normal, dof = best.normal, task.degrees(problem)
    alike = len(other.coefficients) == len(problem.model.coefficients)
    seen = residual.coloured or envelope_lack_of_fit_sigma(residual, best.left) > LIMITS.envelope_sigma
    return alike or seen or is_much_or_hidden(normal.chi2, normal.data_chi2, dof)


def _alternative_summaries(task: Task, alternatives: Sequence[RingDownModel]) -> Iterator[ModelSummary]:
    """What other models make of a task, as far as they get through it."""
    for model in alternatives:
        try:
            problem, best = find_minimum(task, model)
            yield _model_summary(*_without_interference(task, problem, best, residual_left(task, problem, best)))
        except RefusedError:
            continue


def _model_summary(task: Task, problem: FitProblem, best: Minimum, residual: Residual) -> ModelSummary:
    """A fit as its alternatives see it."""
    model, dof = problem.model, task.degrees(problem)
    chi2, size = best.normal.chi2 / dof, int(np.count_nonzero(problem.free))
    public = public_parameters(task, problem, best)
    excess = residual.excess / dof
    return ModelSummary(model.name, chi2, excess, size, model.losses, public.parameters, residual.widening)


def _without_interference(
    task: Task, problem: FitProblem, best: Minimum, residual: Residual
) -> tuple[Task, FitProblem, Minimum, Residual]:
    """The task freed from hum and drift that the residual shows, the fit that is joint with them, what it leaves.

    In an angle of few periods a motion that the model does not follow looks like drift too: what is hum or drift
    there leaves hardly anything once it is gone.
    """
    try:
        beside = without_interference(problem, best, residual, task.chosen, task.noise, task.frequency_hz)
    except FAILURES:
        beside = None  # the verdict on the residual says what is wrong with it
    if beside is None:
        return task, problem, best, residual
    chosen, after = replace(task.chosen, notes=(*task.chosen.notes, *beside.notes)), beside.problem
    freed = replace(task, record=after.record, noise=beside.noise, noise_sd=after.noise_sd, chosen=chosen)
    left = residual_left(freed, after, beside.fitted)
    if task.record.quantity == "angle" and left.surplus > LIMITS.drift_left_share * residual.surplus:
        return task, problem, best, residual
    return freed, after, beside.fitted, left

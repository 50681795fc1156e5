"""The fit of one ring-down, from raw samples to parameters with their errors."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .goodness_of_fit.acceptance import is_much_or_hidden
from .goodness_of_fit.envelope_lack_of_fit import envelope_lack_of_fit_sigma
from .goodness_of_fit.failure_cause import refuse_by_cause, refuse_lost_contact
from .goodness_of_fit.interference import fit_with_interference
from .goodness_of_fit.model_comparison import Comparison, ModelSummary, compare_models, refuse_decided
from .goodness_of_fit.residual import Residual
from .goodness_of_fit.verdict import assess_fit, published_parameters, residual_left
from .initial_guess.guess import observes_dipole
from .least_squares.constraints import fixed_values
from .least_squares.problem import FitProblem, Minimum
from .noise.model import OWN, OWN_FLOOR, OWN_RESIDUAL, NoiseModel
from .numerics.blas_threads import one_thread_for_products
from .physics.models import RingDownModel, alternatives_of, model_named
from .prepared_record import PreparedRecord, prepare_record
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .result import FitResult
from .screening.screening import few_at_full_scale
from .screening.windows import Window, check_window
from .solve import FAILURES, find_minimum
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.goodness_of_fit


def fit_ring_down(
    record: RingDownRecord,
    variant: str | RingDownModel,
    window: Window = "d30",
    *,
    noise: NoiseModel | None = None,
    fixed: Mapping[str, float] | None = None,
    hold_if_inseparable: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a declared model to a ring-down; start values come from the data.

    Example:
        >>> record = RingDownRecord(samples=dmdt, sampling_rate_hz=61_035.0, quantity="dmdt")
        >>> result = fit_ring_down(record, "jewel", "n50")
        >>> result.verdict, result.parameters["f_nat_hz"].value
        ('good', 213.25)

    Args:
        record: RX samples: dm/dt, volts or angle.
        variant: "thread", "jewel" or another declared model (models.py) by name, or any model itself.
        window: "n50" (0.24 s), "d30" (until 30 % of the maximum is left) or seconds.
        noise: measured elsewhere; None: from the record itself.
        fixed: values of f_nat_hz, m_r_am2 or loss coefficients that are not to be fitted.
        hold_if_inseparable: values at which losses are held only if the window cannot separate them from others.

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
    values = fixed_values(model, fixed, dipole=dipole)
    known = _holdable_losses(model, hold_if_inseparable, values, dipole=dipole)
    noise_seconds = 0.0
    try:
        prepared = prepare_record(record, window, noise, values)
        noise_seconds = prepared.noise_seconds
        result = _fit_or_refuse(prepared, model)
        needed = _loss_to_hold(result, known)
        if needed:
            result = _fit_or_refuse(replace(prepared, fixed={**values, **needed}), model)
            result = replace(result, notes=(*result.notes, *_held_loss_notes(needed)))
    except RefusedError as refused:
        result = FitResult.refused(refused)
    seconds = time.perf_counter() - began - noise_seconds
    return replace(result, seconds=seconds, noise_seconds=noise_seconds)


def _holdable_losses(
    model: RingDownModel, hold_if_inseparable: Mapping[str, float] | None, fixed: Mapping[str, float], *, dipole: bool
) -> dict[str, float]:
    """Of the values to hold, those of losses that are fitted together with another one, in the model's order.

    Raises:
        ValueError: a value for something that is no loss of the model, or a value that cannot be held.
    """
    values = hold_if_inseparable or {}
    for name in values:
        if name not in model.losses:
            raise ValueError(f"no hint can be given for {name}: the losses of {model.name} are {model.losses}")
    fixed_values(model, values, dipole=dipole)
    free = [name for name in model.losses if name not in fixed]
    return {name: values[name] for name in free if name in values and len(free) > 1}


def _loss_to_hold(result: FitResult, known: Mapping[str, float]) -> dict[str, float]:
    """The one value that a result needs: of a loss that was inseparable, or of any where losses came out absurd."""
    absurd = result.code is Refusal.OUT_OF_RANGE
    needed = [name for name in known if absurd or name in result.inseparable]
    return {name: known[name] for name in needed[:1]}


def _held_loss_notes(used: Mapping[str, float]) -> tuple[str, ...]:
    """Notes that name the held loss."""
    return tuple(f"hint used: {name} held at {v:g}, the window cannot tell it" for name, v in used.items())


@dataclass(frozen=True, kw_only=True)
class _Fitted:
    """A converged fit, what it was made from, and what it leaves over."""

    prepared: PreparedRecord
    problem: FitProblem
    best: Minimum
    residual: Residual

    @classmethod
    def of(cls, prepared: PreparedRecord, problem: FitProblem, best: Minimum) -> _Fitted:
        """Raises RefusedError where the residual cannot be computed."""
        return cls(prepared=prepared, problem=problem, best=best, residual=residual_left(prepared, problem, best))

    @property
    def degrees(self) -> int:
        """Degrees of freedom of the residual."""
        return self.prepared.degrees(self.problem)


def _fit_or_refuse(prepared: PreparedRecord, model: RingDownModel) -> FitResult:
    """The fit of a prepared record, good or refused."""
    try:
        return _fit(prepared, model)
    except RefusedError as refused:
        try:
            refuse_lost_contact(prepared, model, refused)
        except RefusedError as named:
            return FitResult.refused(named)
        return FitResult.refused(refused)


def _fit(prepared: PreparedRecord, model: RingDownModel) -> FitResult:
    """Fit, compare with rival models if the result is suspect or could be, judge."""
    try:
        problem, best = find_minimum(prepared, model)
    except RefusedError as refused:
        if refused.code is Refusal.NO_CONVERGENCE:
            refuse_by_cause(prepared, model)
        raise
    first = _Fitted.of(prepared, problem, best)
    if prepared.record.quantity == "angle" and prepared.noise.source == OWN:
        first = _at_noise_of_residual(first)
    doubts = (*first.problem.doubts, *few_at_full_scale(prepared.record))
    if doubts:
        first = replace(first, prepared=replace(first.prepared, doubts=doubts))
    final = _without_interference(first)
    better = _better_alternatives(first.prepared, final)
    refuse_decided([other for other in better if other.complete])
    result = assess_fit(final.prepared, final.problem, final.best, final.residual)
    # What leaves a misfit itself can be right only where the residual does not show another cause.
    refuse_decided(better)
    seen = tuple(f"other_variant: {other.seen}" for other in better)
    return replace(result, warnings=result.warnings + seen) if seen else result


def _at_noise_of_residual(fitted: _Fitted) -> _Fitted:
    """The fit of an angle at the noise that its residual shows: the record holds too few harmonics to measure it.

    The level is the residual's own size where it is nothing but noise, else its part above the harmonics.
    """
    prepared, problem, best = fitted.prepared, fitted.problem, fitted.best
    if not fitted.residual.coloured:
        prepared = prepared.at_level(math.sqrt(best.normal.chi2 / fitted.degrees), OWN_RESIDUAL)
        return _Fitted.of(prepared, *find_minimum(prepared, problem.model))
    if fitted.residual.floor is None:
        return fitted
    prepared = prepared.with_white_noise(fitted.residual.floor.sd(prepared.record.sampling_rate_hz), OWN_FLOOR)
    problem = replace(problem, noise_sd=prepared.noise_sd)
    at = problem.evaluate(best.state, prepared.chosen.last)
    return _Fitted.of(prepared, problem, replace(best, state=at.state, normal=at.normal, moments=at.moments))


def _better_alternatives(prepared: PreparedRecord, fitted: _Fitted) -> list[Comparison]:
    """The alternatives to a model that explain the record better, where that could be.

    Each is fitted jointly with the hum and the drift that it needs itself, from `prepared`, which holds both: a wrong
    model takes a part of its own misfit for interference.
    """
    alternatives = alternatives_of(fitted.problem.model, prepared.record.quantity)
    alternatives = tuple(other for other in alternatives if _can_matter(fitted, other))
    if not alternatives:
        return []
    try:
        own = _model_summary(fitted)
    except RefusedError:
        return []  # it will be refused for that
    theirs = sorted(_alternative_summaries(prepared, alternatives), key=lambda other: other.chi2_per_dof)
    found = [compare_models(own, other, fitted.degrees) for other in theirs]
    return [comparison for comparison in found if comparison is not None]


def _can_matter(fitted: _Fitted, other: RingDownModel) -> bool:
    """A law with as many coefficients always can: what one leaves of a record of the other is little."""
    normal, residual = fitted.best.normal, fitted.residual
    alike = len(other.coefficients) == len(fitted.problem.model.coefficients)
    seen = residual.coloured or envelope_lack_of_fit_sigma(residual, fitted.best.left) > LIMITS.envelope_sigma
    return alike or seen or is_much_or_hidden(normal.chi2, normal.data_chi2, fitted.degrees)


def _alternative_summaries(prepared: PreparedRecord, alternatives: Sequence[RingDownModel]) -> Iterator[ModelSummary]:
    """The fits of other models to a prepared record, as far as they converge."""
    for model in alternatives:
        try:
            yield _model_summary(_without_interference(_Fitted.of(prepared, *find_minimum(prepared, model))))
        except RefusedError:
            continue


def _model_summary(fitted: _Fitted) -> ModelSummary:
    """A fit as its alternatives are compared with it."""
    model, dof = fitted.problem.model, fitted.degrees
    return ModelSummary(
        name=model.name,
        chi2_per_dof=fitted.best.normal.chi2 / dof,
        excess=fitted.residual.excess / dof,
        size=int(np.count_nonzero(fitted.problem.free)),
        losses=model.losses,
        parameters=published_parameters(fitted.prepared, fitted.problem, fitted.best).parameters,
        widening=fitted.residual.widening,
    )


def _without_interference(fitted: _Fitted) -> _Fitted:
    """The fit that is joint with the hum and the drift that its residual shows; itself if it shows none.

    In an angle of few periods a motion that the model does not follow looks like drift too. Hum and drift are
    accepted there only if hardly anything is left over without them.
    """
    prepared = fitted.prepared
    try:
        joint = fit_with_interference(
            fitted.problem, fitted.best, fitted.residual, prepared.chosen, prepared.noise, prepared.frequency_hz
        )
    except FAILURES:
        return fitted  # the verdict on the residual says what is wrong with it
    if joint is None:
        return fitted
    after = joint.problem
    freed = replace(
        prepared,
        record=after.record,
        noise=joint.noise,
        noise_sd=after.noise_sd,
        chosen=replace(prepared.chosen, notes=(*prepared.chosen.notes, *joint.notes)),
    )
    left = _Fitted.of(freed, after, joint.fitted)
    if (
        prepared.record.quantity == "angle"
        and left.residual.surplus > LIMITS.drift_left_share * fitted.residual.surplus
    ):
        return fitted
    return left

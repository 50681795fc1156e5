"""The verdict on a minimum: quality figures, warnings, published parameters, or a refusal."""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.least_squares.constraints import refuse_out_of_bounds
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.problem import FitProblem, Minimum
from platform_daemon.estimation.least_squares.public_parameters import (
    PublicParameters,
    by_convention,
    propagate_to_public,
)
from platform_daemon.estimation.prepared_record import PreparedRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.result import FitResult, FittedModel
from platform_daemon.estimation.solve import FAILURES, refuse_beat
from platform_daemon.estimation.thresholds import THRESHOLDS

from .acceptance import doubts, is_unexplained, refuse_unexplained, refuse_untrustworthy
from .block_residual import residual_of
from .channel_gains import find_channel_gains
from .collinearity import CollinearLosses, collinear_losses, collinearity_warning, separating_window_s
from .compression import find_compression
from .flat_tops import PERIODS, find_flat_tops
from .interference import zones_of
from .lack_of_fit import (
    ResidualFindings,
    colour_notes,
    is_large,
    is_worth_a_search,
    lack_of_fit_warnings,
    may_be_compressed,
    refuse_lack_of_fit,
    refuse_second_oscillation,
    refuse_shape,
)
from .mirror_ambiguity import mirror_warnings
from .plausibility import plausibility_warnings
from .residual import Residual
from .residual_jacobian import LinearisedResidual, linearise_residual
from .second_oscillation import SecondOscillation, find_second_oscillation

LIMITS = THRESHOLDS.goodness_of_fit


def assess_fit(prepared: PreparedRecord, problem: FitProblem, best: Minimum, residual: Residual) -> FitResult:
    """Quality figures and the verdict."""
    record, model, chosen = prepared.record, problem.model, prepared.chosen
    squares = float(best.normal.squares_by_channel.sum())
    energy = float(best.moments.energy.sum())
    sums = best.moments.products[:, -1]
    r2 = 1.0 - squares / (energy - float(sums @ sums) / prepared.samples)
    nrmse = math.sqrt(squares / energy)
    dof = prepared.degrees(problem)
    chi2 = best.normal.chi2 / dof
    by_channel = tuple(float(c) * record.channels / dof for c in best.normal.chi2_by_channel)
    found = residual_findings(prepared, problem, best, residual)
    if is_unexplained(r2, chi2):
        refuse_beat(prepared)
        refuse_second_oscillation(found.second, model.losses, prepared.frequency_hz)
    refuse_unexplained(model.name, r2, chi2)
    refuse_shape(residual, found)
    refuse_second_oscillation(found.second, model.losses, prepared.frequency_hz)
    refuse_lack_of_fit(model.name, residual, found)
    public = published_parameters(prepared, problem, best)
    state = by_convention(best.state, model)
    refuse_untrustworthy(model, public)
    refuse_out_of_bounds(model, public, state.dynamics.amplitude)
    public = public.widened(residual.widening)
    tangle = collinear_losses(model, public)
    tangled = () if tangle is None else (_collinearity_seen(problem, state, residual, public, tangle),)
    return FitResult(
        verdict="good",
        warnings=(
            *lack_of_fit_warnings(
                residual,
                found,
                {n: public.parameters[n] for n in model.losses},
                chi2_is_large=is_large(chi2, dof, prepared.noise),
            ),
            *prepared.doubts,
            *tangled,
            *doubts(model, public, tangle, prepared.periods),
            *mirror_warnings(state.observation, public),
            *plausibility_warnings(record.quantity, public.parameters),
        ),
        notes=(*chosen.notes, *problem.knowledge.notes, *colour_notes(residual)),
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
        samples=prepared.samples,
        iterations=problem.passes,
        noise_source=prepared.noise.source,
        fitted=FittedModel(model, state, np.tile(problem.noise_sd[:, None], 2) if best.sd is None else best.sd),
    )


def _collinearity_seen(
    problem: FitProblem, state: FitState, residual: Residual, public: PublicParameters, tangle: CollinearLosses
) -> str:
    """The losses that cannot be separated, with the window in which they could be."""
    return collinearity_warning(tangle, separating_window_s(problem, state, residual, public, tangle))


def published_parameters(prepared: PreparedRecord, problem: FitProblem, best: Minimum) -> PublicParameters:
    """The public parameters of a minimum."""
    state = by_convention(best.state, problem.model)
    try:
        # The start already obeyed the convention; only a fit that crossed over needs its derivatives again.
        normal = best.normal if state is best.state else problem.evaluate(state, prepared.chosen.last).normal
        return propagate_to_public(problem.model, state, normal, problem.free)
    except FAILURES as error:
        raise RefusedError(Refusal.OUT_OF_RANGE, str(error)) from error


def residual_findings(
    prepared: PreparedRecord, problem: FitProblem, best: Minimum, residual: Residual
) -> ResidualFindings:
    """What the residual holds, if it is not noise; a second oscillation and a bend only if worth a search."""
    # An angle of few digits leaves small lines everywhere.
    angle = prepared.record.quantity == "angle"
    thorough = residual.coloured and may_be_compressed(residual) if angle else is_worth_a_search(residual)
    if not (residual.coloured or thorough):
        return ResidualFindings()
    beginning = int(PERIODS * residual.rate_hz / prepared.frequency_hz)
    try:
        leftover = linearise_residual(
            residual if thorough else residual.beginning(beginning),
            model=problem.model,
            state=best.tabulated,
            free=problem.free,
            first=prepared.chosen.first,
            dt_s=prepared.record.dt_s,
        )
        clipped = find_flat_tops(leftover.beginning(beginning))
        gains = find_channel_gains(leftover)
        if not thorough:
            return ResidualFindings(clipped=clipped, gains=gains)
        bent = find_compression(leftover) if may_be_compressed(residual) else None
        return ResidualFindings(_second(leftover, prepared, best), bent, clipped, gains)
    except FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error


def _second(leftover: LinearisedResidual, prepared: PreparedRecord, best: Minimum) -> SecondOscillation | None:
    """A second oscillation; in an angle none that may be the swing itself."""
    second = find_second_oscillation(leftover)
    angle = prepared.record.quantity == "angle"
    return None if second is not None and angle and _may_be_motion(second.frequency_hz, prepared, best) else second


def _may_be_motion(frequency_hz: float, prepared: PreparedRecord, best: Minimum) -> bool:
    """True at the harmonics of a swing and over their sweep: in few periods it is wide."""
    margin = LIMITS.apart_turns / (prepared.samples * prepared.record.dt_s)
    return bool(zones_of(best.state, margin).holds(frequency_hz))


def residual_left(prepared: PreparedRecord, problem: FitProblem, best: Minimum) -> Residual:
    """What the fit leaves over."""
    try:
        return residual_of(
            prepared.record,
            problem.workspace,
            best.tabulated,
            chosen=prepared.chosen,
            noise=prepared.noise,
            noise_sd=prepared.noise_sd,
        )
    except FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error

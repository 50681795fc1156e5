"""From start values to the minimum; where there is none, why."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from .initial_guess.guess import InitialState, guess_initial_state, observes_dipole
from .least_squares.constraints import constraints_of, free_mask, with_fixed
from .least_squares.gauss_newton import FitState
from .least_squares.multiple_minima import ambiguity
from .least_squares.noise_weighting import weighted_by_harmonic
from .least_squares.problem import FitProblem, Minimum, NoConvergenceError
from .least_squares.progressive import CAREFUL, QUICK, fit_progressively
from .least_squares.public_parameters import POOR_CHI2, by_convention, propagate_to_public, refuse_faint
from .physics.models import RingDownModel
from .physics.trajectory.direct import LostTrajectoryError
from .physics.trajectory.initial_conditions import NoInitialConditionsError
from .prepared_record import PreparedRecord
from .refusal import Refusal, RefusedError
from .screening.two_resonators import refuse_two_lines
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.start_values

_LOOSE = replace(CAREFUL, early=LIMITS.coarse_early_chi2, late=LIMITS.coarse_early_chi2, final=LIMITS.coarse_final_chi2)
FAILURES = (NoConvergenceError, LostTrajectoryError, NoInitialConditionsError, np.linalg.LinAlgError)


def find_minimum(prepared: PreparedRecord, model: RingDownModel) -> tuple[FitProblem, Minimum]:
    """Minimise chi^2 from start values found in the data.

    Returns:
        The problem, which counts its passes over the samples, and its minimum.

    Raises:
        RefusedError: no start value led to a minimum, or two resonators are the reason why.
    """
    record, chosen = prepared.record, prepared.chosen
    start = guess_initial_state(
        record,
        model,
        first=chosen.first,
        last=chosen.last,
        frequency_hz=prepared.frequency_hz,
        noise_sd=prepared.noise_sd,
    )
    free = free_mask(model, start.state(start.amplitudes[0]).size, prepared.fixed)
    knowledge = constraints_of(model, prepared.fixed, dipole=observes_dipole(record, model))
    problem = FitProblem(
        record=record, model=model, noise_sd=prepared.noise_sd, free=free, first=chosen.first, knowledge=knowledge
    )
    try:
        return problem, _weighted(problem, _best_fit(problem, start, prepared), prepared)
    except RefusedError as refused:
        if refused.code is Refusal.NO_CONVERGENCE and prepared.periods < LIMITS.short_periods:
            raise RefusedError(Refusal.TOO_SHORT, f"no minimum found in {prepared.periods:.1f} periods") from refused
        raise


def find_minimum_coarsely(prepared: PreparedRecord, model: RingDownModel) -> tuple[FitProblem, Minimum] | None:
    """A minimum where none was found: as if the noise were a part of the signal, so that a misfit has little weight."""
    samples = prepared.record.samples[:, prepared.chosen.first : prepared.chosen.last]
    rms = np.sqrt(np.mean(samples.var(axis=1)))
    start = guess_initial_state(
        prepared.record,
        model,
        first=prepared.chosen.first,
        last=prepared.chosen.last,
        frequency_hz=prepared.frequency_hz,
        noise_sd=prepared.noise_sd,
    )
    for part, amplitude in product(LIMITS.coarse_noise_shares, start.amplitudes):
        state = _start_state(start.state(amplitude), model, prepared)
        free = free_mask(model, state.size, prepared.fixed)
        problem = FitProblem(
            record=prepared.record,
            model=model,
            noise_sd=np.maximum(prepared.noise_sd, part * rms),
            free=free,
            first=prepared.chosen.first,
        )
        try:
            return problem, fit_progressively(
                problem, state, start_periods=start.periods, last=prepared.chosen.last, schedule=_LOOSE
            )
        except FAILURES:
            continue
    return None


def _start_state(state: FitState, model: RingDownModel, prepared: PreparedRecord) -> FitState:
    """A start by convention, to which fixed values refer."""
    return with_fixed(by_convention(state, model), model, prepared.fixed)


def _weighted(problem: FitProblem, best: Minimum, prepared: PreparedRecord) -> Minimum:
    """The minimum with every harmonic weighted by the noise at its frequency."""
    try:
        return weighted_by_harmonic(problem, best, prepared.chosen.last, prepared.noise, prepared.frequency_hz)
    except FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error


def _best_fit(problem: FitProblem, start: InitialState, prepared: PreparedRecord) -> Minimum:
    """Quickly from the most trusted start; carefully, and from the others, only if that explains the record badly."""
    found: list[Minimum] = []
    dof = prepared.degrees(problem)
    failure = "no start value led anywhere"
    for amplitude, schedule in [(start.amplitudes[0], QUICK), *((a, CAREFUL) for a in start.amplitudes)]:
        state = _start_state(start.state(amplitude), problem.model, prepared)
        try:
            found.append(
                fit_progressively(
                    problem, state, start_periods=start.periods, last=prepared.chosen.last, schedule=schedule
                )
            )
        except FAILURES as error:
            failure = str(error)
            continue
        if found[-1].normal.chi2 < POOR_CHI2 * dof:
            break
    if not found:
        first = _start_state(start.state(start.amplitudes[0]), problem.model, prepared)
        _refuse_faint(prepared, problem, first)
        refuse_beat(prepared)
        raise RefusedError(Refusal.NO_CONVERGENCE, failure)
    problem.doubts = ambiguity(found, problem.model, problem.free, dof)
    return min(found, key=lambda fitted: fitted.normal.chi2)


def _refuse_faint(prepared: PreparedRecord, problem: FitProblem, state: FitState) -> None:
    """Refuse a signal that is too weak for its amplitude to be known, as the reason why a fit failed."""
    try:
        normal = problem.evaluate(state, prepared.chosen.last).normal
        public = propagate_to_public(problem.model, state, normal, problem.free)
    except FAILURES:
        return
    refuse_faint(public)


def refuse_beat(prepared: PreparedRecord) -> None:
    """Refuse two resonators: the reason why a fit failed. A window may end where they first cancel each other."""
    if prepared.record.quantity != "angle":
        refuse_two_lines(prepared.record, prepared.frequency_hz, prepared.noise_sd)

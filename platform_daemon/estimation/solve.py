"""From start values to the minimum; where there is none, why."""

from __future__ import annotations

import math
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
    if not found and (minimum := _with_scales_held_first(problem, start, prepared)) is not None:
        return minimum
    if not found:
        first = _start_state(start.state(start.amplitudes[0]), problem.model, prepared)
        _refuse_faint(prepared, problem, first)
        refuse_beat(prepared)
        raise RefusedError(Refusal.NO_CONVERGENCE, failure)
    problem.doubts = ambiguity(found, problem.model, problem.free, dof)
    return min(found, key=lambda fitted: fitted.normal.chi2)


def _with_scales_held_first(problem: FitProblem, start: InitialState, prepared: PreparedRecord) -> Minimum | None:
    """The minimum from the best one with the speed at which a friction falls held; None if none is found.

    While a window grows that speed is hardly known, and a step of it leads to where the friction is gone.

    Raises:
        RefusedError: the record does not tell that speed.
    """
    scales = [k for k in problem.model.speeds_of_friction if problem.free[3 + k]]
    if not scales:
        return None
    free = problem.free.copy()
    free[[3 + k for k in scales]] = False
    first = start.state(start.amplitudes[0])
    found: list[tuple[float, Minimum]] = []

    def held(log_ratio: float) -> float:
        """chi^2 with the speed at so many times its start; infinite if no fit converges."""
        near = min(found, key=lambda pair: abs(pair[0] - log_ratio))[1].state if found else first
        values = [
            q * math.exp(log_ratio) if k in scales else near.dynamics.values[k]
            for k, q in enumerate(first.dynamics.values)
        ]
        state = replace(near, dynamics=replace(near.dynamics, values=tuple(values)))
        periods = prepared.periods + 1.0 if found else start.periods
        try:
            minimum = fit_progressively(
                replace(problem, free=free, passes=0),
                _start_state(state, problem.model, prepared),
                start_periods=periods,
                last=prepared.chosen.last,
                schedule=CAREFUL,
            )
        except FAILURES:
            return math.inf
        found.append((log_ratio, minimum))
        return float(minimum.normal.chi2)

    for ratio in LIMITS.held_scale_ratios:
        held(math.log(ratio))
    if not found:
        return None
    centre = min(found, key=lambda pair: pair[1].normal.chi2)[0]
    from scipy.optimize import minimize_scalar  # here, because only such frictions need it

    limits = centre - LIMITS.held_scale_reach, centre + LIMITS.held_scale_reach
    minimize_scalar(held, bounds=limits, method="bounded", options={"xatol": LIMITS.held_scale_log_error})
    best = min((minimum for _, minimum in found), key=lambda m: m.normal.chi2)
    problem.passes = 0
    try:
        whole = prepared.periods + 1.0
        freed = fit_progressively(problem, best.state, start_periods=whole, last=prepared.chosen.last, schedule=CAREFUL)
        there = problem.evaluate(freed.state, prepared.chosen.last).normal.chi2
        if there - best.normal.chi2 < LIMITS.held_scale_chi2 * max(1.0, there / prepared.degrees(problem)):
            return freed
    except FAILURES:
        pass
    names = ", ".join(problem.model.coefficients[k].name for k in scales)
    value = best.state.dynamics.values[scales[0]]
    raise RefusedError(Refusal.NO_CONVERGENCE, f"the record does not tell {names}: hold it (--fix {names}={value:.3g})")


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

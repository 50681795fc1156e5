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
from .refusal import Refusal, RefusedError
from .screening.two_resonators import refuse_two_lines
from .task import Task

_SHORT_PERIODS = 12.0
_COARSE = (0.2, 1.0)  # of the rms signal of a channel
_LOOSE = replace(CAREFUL, early=3.0, late=3.0, final=1.0)
FAILURES = (NoConvergenceError, LostTrajectoryError, NoInitialConditionsError, np.linalg.LinAlgError)


def find_minimum(task: Task, model: RingDownModel) -> tuple[FitProblem, Minimum]:
    """Minimise chi^2 from start values found in the data."""
    record, chosen = task.record, task.chosen
    start = guess_initial_state(record, model, chosen.first, chosen.last, task.frequency_hz, task.noise_sd)
    free = free_mask(model, start.state(start.amplitudes[0]).size, task.fixed)
    knowledge = constraints_of(model, task.fixed, dipole=observes_dipole(record, model))
    problem = FitProblem(record, model, task.noise_sd, free, chosen.first, knowledge)
    try:
        return problem, _weighted(problem, _best_fit(problem, start, task), task)
    except RefusedError as refused:
        if refused.code is Refusal.NO_CONVERGENCE and task.periods < _SHORT_PERIODS:
            raise RefusedError(Refusal.TOO_SHORT, f"no minimum found in {task.periods:.1f} periods") from refused
        raise


def find_minimum_coarsely(task: Task, model: RingDownModel) -> tuple[FitProblem, Minimum] | None:
    """A minimum where none was found: as if the noise were a part of the signal, so that a misfit hardly counts."""
    samples = task.record.samples[:, task.chosen.first : task.chosen.last]
    rms = np.sqrt(np.mean(samples.var(axis=1)))
    start = guess_initial_state(
        task.record, model, task.chosen.first, task.chosen.last, task.frequency_hz, task.noise_sd
    )
    for part, amplitude in product(_COARSE, start.amplitudes):
        state = _start_state(start.state(amplitude), model, task)
        free = free_mask(model, state.size, task.fixed)
        problem = FitProblem(task.record, model, np.maximum(task.noise_sd, part * rms), free, task.chosen.first)
        try:
            return problem, fit_progressively(problem, state, start.periods, task.chosen.last, _LOOSE)
        except FAILURES:
            continue
    return None


def _start_state(state: FitState, model: RingDownModel, task: Task) -> FitState:
    """A start by convention, to which fixed values refer."""
    return with_fixed(by_convention(state, model), model, task.fixed)


def _weighted(problem: FitProblem, best: Minimum, task: Task) -> Minimum:
    """The minimum with every harmonic weighted by the noise that stands there."""
    try:
        return weighted_by_harmonic(problem, best, task.chosen.last, task.noise, task.frequency_hz)
    except FAILURES as error:
        raise RefusedError(Refusal.NO_CONVERGENCE, str(error)) from error


def _best_fit(problem: FitProblem, start: InitialState, task: Task) -> Minimum:
    """Quickly from the most trusted start; carefully, and from the others, only if that explains the record badly."""
    found: list[Minimum] = []
    dof = task.degrees(problem)
    failure = "no start value led anywhere"
    for amplitude, schedule in [(start.amplitudes[0], QUICK), *((a, CAREFUL) for a in start.amplitudes)]:
        state = _start_state(start.state(amplitude), problem.model, task)
        try:
            found.append(fit_progressively(problem, state, start.periods, task.chosen.last, schedule))
        except FAILURES as error:
            failure = str(error)
            continue
        if found[-1].normal.chi2 < POOR_CHI2 * dof:
            break
    if not found:
        first = _start_state(start.state(start.amplitudes[0]), problem.model, task)
        _refuse_faint(task, problem, first)
        refuse_beat(task)
        raise RefusedError(Refusal.NO_CONVERGENCE, failure)
    problem.doubts = ambiguity(found, problem.model, problem.free, dof)
    return min(found, key=lambda fitted: fitted.normal.chi2)


def _refuse_faint(task: Task, problem: FitProblem, state: FitState) -> None:
    """A signal too weak for its size to be told, at these start values, as the reason why a fit went wrong."""
    try:
        normal = problem.evaluate(state, task.chosen.last).normal
        public = propagate_to_public(problem.model, state, normal, problem.free)
    except FAILURES:
        return
    refuse_faint(public)


def refuse_beat(task: Task) -> None:
    """Two resonators as the reason why a fit went wrong; a window may end where they first cancel each other."""
    if task.record.quantity != "angle":
        refuse_two_lines(task.record, task.frequency_hz, task.noise_sd)

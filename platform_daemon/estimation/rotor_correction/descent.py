"""Least squares of one angle from a start that is known: few steps, no search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from platform_daemon.estimation.least_squares.constraints import constraints_of, fixed_values, free_mask
from platform_daemon.estimation.least_squares.gauss_newton import FitState, gauss_newton_step
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.least_squares.problem import (
    ALL_SAMPLES,
    FitProblem,
    Minimum,
    NoConvergenceError,
    Subsample,
)
from platform_daemon.estimation.least_squares.progressive import QUICK, fit_progressively
from platform_daemon.estimation.least_squares.public_parameters import by_convention, public_jacobian
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import COARSE, EXACT
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.prepared_record import prepare_record
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.solve import FAILURES, find_minimum
from platform_daemon.estimation.thresholds import THRESHOLDS

from .coordinates import TURNS, OneAngle, OneAngleCoordinates

LIMITS = THRESHOLDS.rotor_correction


def state_of(coordinates: OneAngleCoordinates, at: OneAngle) -> FitState:
    """Of a motion as it is seen.  Raises ValueError, LostTrajectoryError where there is none."""
    observation = DipoleObservation(at.m_r_am2, coordinates.rotated(at.vector[-TURNS:]), np.eye(3))
    return FitState(coordinates.dynamics(at), observation, np.zeros(3))


def problem_of(record: RingDownRecord, model: RingDownModel, state: FitState, noise_sd: Array) -> FitProblem:
    """Of dm/dt."""
    fixed = fixed_values(model, None, dipole=True)
    knowledge = constraints_of(model, fixed, dipole=True)
    free = free_mask(model, state.size, fixed)
    return FitProblem(
        record=record, model=model, noise_sd=noise_sd, free=free, first=record.valid_from, knowledge=knowledge
    )


def descended(
    problem: FitProblem, state: FitState, last: int, least_fall: float, some: Subsample = ALL_SAMPLES
) -> Minimum:
    """Gauss-Newton's steps from a state over samples up to `last`, until one promises less of chi^2 than `least_fall`;
    some: of these samples alone.

    Raises NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError where they lead nowhere.
    """
    before = np.inf
    for _ in range(LIMITS.most_descending):
        at = problem.evaluate(state, last, some, EXACT if some is ALL_SAMPLES else COARSE)
        step, fall = gauss_newton_step(at.normal, problem.free)
        state = at.state.moved(step)
        if fall < least_fall:
            normal = problem.after(at, step)
            return Minimum(state=state, tabulated=at.state, normal=normal, moments=at.moments, left=max(fall, 0.0))
        if at.normal.chi2 > LIMITS.lost_chi2 * before:
            break
        before = at.normal.chi2
    raise NoConvergenceError("steps from a known start lead nowhere")


def smooth_fit(
    record: RingDownRecord,
    model: RingDownModel,
    window_s: float,
    noise_share: float,
    start: FitState | None = None,
) -> dict[str, float]:
    """Published parameters at the very bottom of chi^2, whatever is left over: a smooth function of the samples.

    Args:
        record: dm/dt.
        model: of one angle.
        window_s: from the first sample on.
        noise_share: of the signal, that stands for misfit and noise, alike in all channels.
        start: near the bottom; None, or where it leads nowhere: it is searched for.

    Raises:
        RefusedError, and what solve.FAILURES lists.
    """
    last = min(record.end, round(window_s * record.sampling_rate_hz))
    cut = RingDownRecord(record.samples[:, :last], record.sampling_rate_hz, "dmdt", valid_from=record.valid_from)
    some = cut.valid.ravel()
    sd = np.full(record.channels, noise_share * float(np.sqrt(some @ some / some.size)))
    least = LIMITS.polished * last
    best = None
    if start is not None:
        try:
            problem, left = problem_of(cut, model, start, sd), LIMITS.nearly_polished * last
            if "tf_over_i_rad_per_s2" in model.losses:  # which differs so much that steps at once would lead astray
                stages, periods = replace(QUICK, final=left), LIMITS.start_periods
                best = fit_progressively(problem, start, start_periods=periods, last=last, schedule=stages)
            else:
                best = descended(problem, start, last, left)
        except (*FAILURES, ValueError):
            best = None
    if best is None:
        noise = NoiseModel.white(sd, record.sampling_rate_hz)
        prepared = prepare_record(cut, window_s, noise, fixed_values(model, None, dipole=True))
        problem, found = find_minimum(prepared, model)
        best = descended(problem, found.state, prepared.chosen.last, least)
    names, values, _ = public_jacobian(model, by_convention(best.state, model))
    return dict(zip(names, values.tolist(), strict=True))

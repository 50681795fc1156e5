"""The fit of a shot: one angle, twice, with what the rotor does beside it taken away in between."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np

from platform_daemon.estimation.goodness_of_fit.verdict import published_parameters, residual_left
from platform_daemon.estimation.least_squares.constraints import fixed_values
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.noise_weighting import weighted_by_harmonic
from platform_daemon.estimation.least_squares.problem import FitProblem, Minimum, Subsample
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.blas_threads import one_thread_for_products
from platform_daemon.estimation.parameters import RODRIGUES, Estimate
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation, rotation_from_rodrigues
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.prepared_record import PreparedRecord, prepare_record
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.estimation.result import FitResult
from platform_daemon.estimation.screening.windows import Window
from platform_daemon.estimation.solve import FAILURES, find_minimum
from platform_daemon.estimation.thresholds import THRESHOLDS

from .coordinates import TURNS, OneAngle
from .descent import descended, problem_of, smooth_fit, state_of
from .table import CONSTANTS, CorrectionTable, Place

LIMITS = THRESHOLDS.rotor_correction
_SOME = Subsample(LIMITS.early_half_cycle)
_SMALL_TURN_RAD = LIMITS.difference_share


def coarse_window_s(model: RingDownModel) -> float:
    """Of the first fit."""
    jewel = "tf_over_i_rad_per_s2" in model.losses
    return LIMITS.coarse_window_s_jewel if jewel else LIMITS.coarse_window_s_thread


def corrected_fit(
    record: RingDownRecord, window: Window, noise: NoiseModel | None, table: CorrectionTable
) -> FitResult:
    """Fit dm/dt that begins with the first RX sample.

    The result is that of one angle, over `window`, of the samples less what the rotor does beside it, with the
    constants and the orientation of the rotor; phi_max and psi stay those of one angle.  Its errors contain the error
    of the table and those of what the adopted model holds.  Refused where the shot lies outside of the table.
    """
    one_thread_for_products()
    began = time.perf_counter()
    try:
        place = table.inside(_seen(record, table))
        samples = min(table.samples, record.samples.shape[1])
        at = table.one_angle_of(place)
        near = state_of(table.coordinates, at)
        left = record.samples.copy()
        left[:, :samples] -= table.beside(place, at, near.dynamics, samples)
    except RefusedError as refused:
        return FitResult.refused(refused)
    except (*FAILURES, LostTrajectoryError, ValueError) as error:
        return _refused(str(error))
    fit = _one_angle_fit(replace(record, samples=left), window, noise, table, near)
    if fit.verdict != "good":
        return fit
    if record.valid_from + fit.samples > table.samples < record.samples.shape[1]:
        window_s, kept_s = fit.window_s or 0.0, table.samples / table.rate_hz
        return _refused(f"the window of {window_s:.3g} s is longer than the {kept_s:.3g} s that the table holds")
    found = _result(fit, table)
    return replace(found, seconds=time.perf_counter() - began - fit.noise_seconds)


def _one_angle_fit(
    record: RingDownRecord, window: Window, noise: NoiseModel | None, table: CorrectionTable, near: FitState
) -> FitResult:
    """Of what the correction leaves, judged by its size alone.

    What else `fit_ring_down` looks for (hum, drift, a second resonator, another variant) takes a hundred times as long
    where more than noise is left, as the table's own error is.
    """
    model = table.coordinates.model
    noise_s = 0.0
    try:
        prepared = prepare_record(record, window, noise, fixed_values(model, None, dipole=True))
        noise_s = prepared.noise_seconds
        problem, best = _minimum(prepared, table, near)
        residual = residual_left(prepared, problem, best)
        public = published_parameters(prepared, problem, best)
    except RefusedError as refused:
        return replace(FitResult.refused(refused), noise_seconds=noise_s)
    squares, energy = float(best.normal.squares_by_channel.sum()), float(best.moments.energy.sum())
    dof = prepared.degrees(problem)
    chi2 = best.normal.chi2 / dof
    # What the table itself leaves, at its worst, in standard deviations of the noise.
    own = (table.left_share**2) * energy / float(np.sum(prepared.noise_sd**2) * prepared.samples)
    if chi2 > LIMITS.refused_chi2 * (1.0 + own):
        return _refused(f"chi2/dof is {chi2:.3g} with the correction: the shot is not that of this rotor")
    seen = f"residual_not_white: chi2/dof is {chi2:.3g} with the correction, whose own error explains {1.0 + own:.3g}"
    warned = (seen,) if chi2 > LIMITS.warned_chi2 * (1.0 + own) else ()
    sums = best.moments.products[:, -1]
    return FitResult(
        verdict="good",
        warnings=(*warned, *problem.doubts),
        notes=(*prepared.chosen.notes, *problem.knowledge.notes),
        parameters=public.parameters,
        covariance=public.covariance,
        covariance_names=public.names,
        r2=1.0 - squares / (energy - float(sums @ sums) / prepared.samples),
        nrmse=math.sqrt(squares / energy),
        chi2_per_dof=chi2,
        chi2_per_dof_by_channel=tuple(float(c) * record.channels / dof for c in best.normal.chi2_by_channel),
        whiteness_by_channel=tuple(residual.flatness.tolist()),
        condition=public.condition,
        window_s=prepared.chosen.last * record.dt_s,
        samples=prepared.samples,
        iterations=problem.passes,
        noise_source=prepared.noise.source,
        noise_seconds=noise_s,
    )


def _minimum(prepared: PreparedRecord, table: CorrectionTable, near: FitState) -> tuple[FitProblem, Minimum]:
    """From where the table has it.  Raises RefusedError."""
    model, last = table.coordinates.model, prepared.chosen.last
    try:
        problem = problem_of(prepared.record, model, near, prepared.noise_sd)
        early = descended(problem, near, last, LIMITS.early_chi2, _SOME)
        best = weighted_by_harmonic(problem, early, last, prepared.noise, prepared.frequency_hz)
        if best is early:  # the noise is white, and nothing has looked at all samples yet
            best = descended(problem, early.state, last, LIMITS.descended_chi2)
        return problem, best
    except (*FAILURES, ValueError):
        return find_minimum(prepared, model)


def _seen(record: RingDownRecord, table: CorrectionTable) -> Place:
    model = table.coordinates.model
    values = smooth_fit(record, model, coarse_window_s(model), LIMITS.coarse_noise_share, table.start_state)
    return table.place_of(table.coordinates.of(values))


def _refused(why: str) -> FitResult:
    return FitResult("refused", reason=f"rotor_correction: {why}")


def _result(fit: FitResult, table: CorrectionTable) -> FitResult:
    """The fit with the constants of the rotor; refused where these lie outside of the table beyond doubt."""
    seen = {name: each.value for name, each in fit.parameters.items()}
    corrected = table.coordinates.of(seen)
    place = table.rotor_of(corrected)
    found = table.values(place)
    constants = [name for name in CONSTANTS if name in found]
    turns = place.vector[-TURNS:]
    rodrigues = rodrigues_from_rotation(table.coordinates.rotated(turns))
    slope = table.slope(corrected) @ _vector_by_published(fit, table, corrected)
    of_noise = slope @ fit.covariance @ slope.T
    outside = table.outside(place, np.sqrt(np.diag(of_noise)))
    if outside is not None:
        return _refused(outside)
    covariance = of_noise + table.held + np.diag(table.error**2)
    published = np.eye(len(covariance))
    published[-TURNS:, -TURNS:] = _rodrigues_by_turns(table, turns)
    covariance = published @ covariance @ published.T
    names = (*constants, *RODRIGUES)
    std = np.sqrt(np.diag(covariance))
    np.fill_diagonal(covariance, std * std)
    values = [*(found[name] for name in constants), *rodrigues.tolist()]
    own = {n: Estimate(float(v), float(s)) for n, v, s in zip(names, values, std, strict=True)}
    return replace(
        fit,
        parameters={name: own.get(name, old) for name, old in fit.parameters.items()},
        covariance=covariance,
        covariance_names=names,
        inseparable=(),
        fitted=None,
    )


def _vector_by_published(fit: FitResult, table: CorrectionTable, corrected: OneAngle) -> Array:
    """Derivatives (1 + k, names) of ln m_r and the one-angle vector by what the fit estimated."""
    order = ["f_nat_hz", *table.coordinates.losses, "phi_max_rad", "psi_start_rad"]
    rows = np.zeros((1 + corrected.vector.size, len(fit.covariance_names)))
    for k, name in enumerate(fit.covariance_names):
        if name == "m_r_am2":
            rows[0, k] = 1.0 / corrected.m_r_am2
        elif name in order:
            rows[1 + order.index(name), k] = 1.0
    places = [fit.covariance_names.index(name) for name in RODRIGUES]
    rows[-TURNS:, places] = np.linalg.inv(_published_by_turns(fit, table, corrected))
    return rows


def _published_by_turns(fit: FitResult, table: CorrectionTable, corrected: OneAngle) -> Array:
    """Derivatives of the fit's own Rodrigues vector, of whichever twin, by the turns."""
    rotation = rotation_from_rodrigues(np.array([fit.parameters[name].value for name in RODRIGUES]))
    own = table.coordinates.rotated(corrected.vector[-TURNS:])
    twin = own.T @ rotation  # the identity, or a half turn about u
    turned = table.coordinates.rotated
    return _by_turns(lambda turns: rodrigues_from_rotation(turned(turns) @ twin), corrected.vector[-TURNS:])


def _rodrigues_by_turns(table: CorrectionTable, turns: Array) -> Array:
    return _by_turns(lambda at: rodrigues_from_rotation(table.coordinates.rotated(at)), turns)


def _by_turns(vector, turns: Array) -> Array:  # type: ignore[no-untyped-def]
    """Derivative (3, 3) of a vector by turns."""
    steps = _SMALL_TURN_RAD * np.eye(TURNS)
    rows = [(vector(turns + step) - vector(turns - step)) / (2.0 * _SMALL_TURN_RAD) for step in steps]
    return np.array(rows).T

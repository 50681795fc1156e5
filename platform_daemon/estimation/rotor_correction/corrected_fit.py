"""The fit of a shot: one angle, twice, with what the rotor does beside it taken away in between."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.goodness_of_fit.verdict import published_parameters
from platform_daemon.estimation.least_squares.constraints import fixed_values
from platform_daemon.estimation.least_squares.gauss_newton import FitState, gauss_newton_step
from platform_daemon.estimation.least_squares.noise_weighting import harmonic_sd, weighted_normal
from platform_daemon.estimation.least_squares.problem import FitProblem, Minimum, Subsample
from platform_daemon.estimation.least_squares.public_parameters import public_jacobian
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
from platform_daemon.estimation.solve import FAILURES
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
    record: RingDownRecord,
    window: Window,
    noise: NoiseModel | None,
    table: CorrectionTable,
    look: OneAngle | None = None,
) -> FitResult:
    """Fit dm/dt that begins with the first RX sample; look: what `first_look` found, None: it is still to be made.

    The result is that of one angle, over `window`, of the samples less what the rotor does beside it, with the
    constants and the orientation of the rotor; phi_max and psi stay those of one angle.  Its errors contain the error
    of the table and those of what the adopted model holds.  Refused where the shot lies outside of the table.
    """
    one_thread_for_products()
    began = time.perf_counter()
    available = min(table.samples, record.end)
    noise_s = 0.0
    try:
        seen = table.inside(table.place_of(first_look(record, table) if look is None else look))
        samples = min(available, table.enough(seen, window))
        prepared = _prepared(record, seen, samples, window, noise, table)
        if prepared.chosen.last >= samples < available:
            prepared = _prepared(record, seen, available, window, noise, table)
        noise_s = prepared.noise_seconds
        if prepared.chosen.last >= table.samples < record.end:
            window_s, kept_s = prepared.chosen.last * record.dt_s, table.samples * record.dt_s
            return _refused(f"the window of {window_s:.3g} s is no shorter than the {kept_s:.3g} s of the table")
        fit = _one_angle_fit(record, prepared, table)
    except RefusedError as refused:
        return replace(FitResult.refused(refused), noise_seconds=noise_s)
    except (*FAILURES, LostTrajectoryError, ValueError) as error:
        return _refused(str(error))
    found = _result(fit, table) if fit.verdict == "good" else fit
    return replace(found, seconds=time.perf_counter() - began - noise_s, noise_seconds=noise_s)


@dataclass(frozen=True, kw_only=True)
class _Prepared(PreparedRecord):
    """Samples less what the correction has at first; near: the motion beside which it has it."""

    near: FitState


def _prepared(
    record: RingDownRecord, seen: Place, samples: int, window: Window, noise: NoiseModel | None, table: CorrectionTable
) -> _Prepared:
    """Raises RefusedError, ValueError, LostTrajectoryError."""
    at = table.one_angle_of(seen)
    near = state_of(table.coordinates, at)
    left = table.taken_from(record.samples[:, :samples], seen, at.m_r_am2, near.dynamics)
    cut = replace(record, samples=left, valid_to=min(record.end, samples))
    model = table.coordinates.model
    made = prepare_record(cut, window, noise, fixed_values(model, None, dipole=True))
    return _Prepared(**vars(made), near=near)


def _one_angle_fit(record: RingDownRecord, prepared: _Prepared, table: CorrectionTable) -> FitResult:
    """Of what the correction leaves, once it is that of the whole window; judged by its size alone.

    What else `fit_ring_down` looks for (hum, drift, a second resonator, another variant) takes a hundred times as long
    where more than noise is left, as the table's own error is.  Raises RefusedError, and what solve.FAILURES lists.
    """
    problem, best, whole = _minimum(record, prepared, table)
    public = published_parameters(whole, problem, best)
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
        chi2_per_dof_by_channel=tuple(float(c) * len(sums) / dof for c in best.normal.chi2_by_channel),
        condition=public.condition,
        window_s=prepared.chosen.last * record.dt_s,
        samples=prepared.samples,
        iterations=problem.passes,
        noise_source=prepared.noise.source,
    )


def _minimum(
    record: RingDownRecord, prepared: _Prepared, table: CorrectionTable
) -> tuple[FitProblem, Minimum, PreparedRecord]:
    """Of the window, first with the correction that its beginning tells, then with the one that it tells itself."""
    coordinates, last = table.coordinates, prepared.chosen.last
    model = coordinates.model
    problem = problem_of(prepared.record, model, prepared.near, prepared.noise_sd)
    early = descended(problem, prepared.near, last, LIMITS.early_chi2, _SOME)
    names, values, _ = public_jacobian(model, early.state)
    corrected = coordinates.of(dict(zip(names, values.tolist(), strict=True)))
    place = table.inside(table.rotor_of(corrected))
    left = table.taken_from(record.samples[:, :last], place, corrected.m_r_am2, early.state.dynamics)
    again = replace(prepared, record=replace(prepared.record, samples=left, valid_to=last))
    problem = problem_of(again.record, model, early.state, again.noise_sd)
    near = descended(problem, early.state, last, math.inf, _SOME)  # one step: it begins where the other one ended
    return problem, _at_the_bottom(problem, near.state, again), again


def _at_the_bottom(problem: FitProblem, state: FitState, prepared: PreparedRecord) -> Minimum:
    """One step with all samples, odd and even harmonics weighted by the noise at their frequencies: the state is that
    of some of the half cycles, a few standard errors off, where chi^2 is a parabola."""
    at = problem.evaluate(state, prepared.chosen.last)
    sd = harmonic_sd(problem, prepared.noise, prepared.frequency_hz)
    normal = weighted_normal(problem.model, at.state, at.moments, sd, at.normal)
    normal = problem.knowledge.added(normal, at.state)
    step, _ = gauss_newton_step(normal, problem.free)
    left = replace(problem.after(at, step), gradient=normal.gradient, matrix=normal.matrix)
    return Minimum(state=at.state.moved(step), tabulated=at.state, normal=left, moments=at.moments, sd=sd)


def first_look(record: RingDownRecord, table: CorrectionTable) -> OneAngle:
    """The fit of the first window.  Raises RefusedError, and what solve.FAILURES lists."""
    model = table.coordinates.model
    values = smooth_fit(record, model, coarse_window_s(model), LIMITS.coarse_noise_share, table.start_state)
    return table.coordinates.of(values)


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

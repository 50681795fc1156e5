"""The fit of one ring-down, from raw samples to parameters with their errors."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .gauss_newton import FitState
from .growing import Fitted, NoConvergenceError, Problem, fit_growing
from .models import RingDownModel, model_named
from .noise import NoiseModel, estimate_noise
from .observation import DipoleObservation
from .publish import Published, by_convention, publish
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .result import FitResult, FittedModel
from .screening import refuse_few_periods, screen
from .start import Start, find_start
from .start_label import NoLabelError
from .trajectory import LostTrajectoryError
from .windows import SampleRange, Window, check_window, select_window

_POOR_CHI2 = 1.5
_UNEXPLAINED_R2 = 0.9
_LARGEST_RELATIVE_STD = 0.05
_LARGEST_RELATIVE_STD_FREE_GAINS = 0.3
_FAILURES = (NoConvergenceError, LostTrajectoryError, NoLabelError, np.linalg.LinAlgError)


def fit_ring_down(
    record: RingDownRecord,
    variant: str,
    window: Window = "d30",
    *,
    noise: NoiseModel | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a declared model to a ring-down; start values come from the data.

    Args:
        record: RX samples, dm/dt or volts.
        variant: "thread" or "jewel".
        window: "n50" (0.24 s), "d30" (until 30 % of the maximum is left) or seconds.
        noise: measured elsewhere; None: from the record itself.
        fixed: values of f_nat_hz, m_r_am2 or loss coefficients that are not to be fitted.

    Returns:
        A FitResult; unusable data give verdict "refused" with a reason, never an exception.

    Raises:
        ValueError: an unknown variant, window or fixed name (mistakes of the caller, not of the data).
    """
    began = time.perf_counter()
    model = model_named(variant)
    check_window(window)
    fixed = dict(fixed or {})
    _check_fixed(fixed, model, record)
    try:
        result = _fit(record, model, window, noise, fixed)
    except RefusedError as refused:
        result = FitResult("refused", reason=str(refused))
    return replace(result, seconds=time.perf_counter() - began)


def _check_fixed(fixed: Mapping[str, float], model: RingDownModel, record: RingDownRecord) -> None:
    """Only parameters that the model has can be fixed, and only to finite numbers."""
    allowed = {"f_nat_hz", *(c.name for c in model.coefficients)}
    if record.quantity == "dmdt":
        allowed.add("m_r_am2")
    for name, value in fixed.items():
        if name not in allowed:
            raise ValueError(f"{name} cannot be fixed for {model.name}: allowed are {', '.join(sorted(allowed))}")
        if not math.isfinite(value):
            raise ValueError(f"{name} is fixed to {value!r}, which is not a finite number")


def _fit(
    record: RingDownRecord,
    model: RingDownModel,
    window: Window,
    noise: NoiseModel | None,
    fixed: Mapping[str, float],
) -> FitResult:
    """The fit proper; raises RefusedError."""
    line = screen(record)
    noise = estimate_noise(record) if noise is None else noise
    sd = _usable_sd(noise, record)
    chosen = select_window(record, window, line.frequency_hz, sd)
    if chosen.last <= chosen.first:
        raise RefusedError(Refusal.TOO_SHORT, "the window ends before the valid samples begin")
    refuse_few_periods((chosen.last - chosen.first) * record.dt_s, line.frequency_hz)
    start = find_start(record, model, chosen.first, chosen.last, line.frequency_hz, sd)
    problem = Problem(record, model, sd, _free_mask(model, start, fixed), chosen.first)
    best = _best_fit(problem, start, chosen, fixed)
    return _judged(problem, best, chosen)


def _usable_sd(noise: NoiseModel, record: RingDownRecord) -> np.ndarray:
    """Standard deviations (channels,), kept above rounding so that noise-free records can be fitted."""
    sd = np.asarray(noise.sd, dtype=np.float64)
    if sd.shape != (record.channels,) or not np.all(np.isfinite(sd)) or np.any(sd < 0.0):
        raise ValueError(f"noise.sd must be {record.channels} finite numbers >= 0, not {sd!r}")
    floor = 1e-9 * float(np.sqrt(np.mean(record.valid**2)))
    return np.maximum(sd, floor)


def _free_mask(model: RingDownModel, start: Start, fixed: Mapping[str, float]) -> np.ndarray:
    """True for the internal parameters that are fitted, bool (size,)."""
    free = np.ones(start.candidates[0].size, dtype=bool)
    free[1] = "f_nat_hz" not in fixed
    for k, coefficient in enumerate(model.coefficients):
        free[3 + k] = coefficient.name not in fixed
    if "m_r_am2" in fixed:
        free[3 + len(model.coefficients)] = False
    return free


def _with_fixed(state: FitState, model: RingDownModel, fixed: Mapping[str, float]) -> FitState:
    """The state with fixed values put in."""
    d = state.dynamics
    w = 2.0 * math.pi * fixed["f_nat_hz"] if "f_nat_hz" in fixed else d.w
    values = tuple(fixed.get(c.name, q) for c, q in zip(model.coefficients, d.values, strict=True))
    observation = state.observation
    if "m_r_am2" in fixed and isinstance(observation, DipoleObservation):
        observation = replace(observation, m_r=fixed["m_r_am2"])
    return FitState(replace(d, w=w, values=values), observation, state.offsets)


def _best_fit(problem: Problem, start: Start, chosen: SampleRange, fixed: Mapping[str, float]) -> Fitted:
    """Fit from the most trusted start; the others are tried only if that explains the record badly."""
    best: Fitted | None = None
    dof = problem.record.channels * (chosen.last - chosen.first)
    failure = "no start value led anywhere"
    for candidate in start.candidates:
        state = _with_fixed(candidate, problem.model, fixed)
        try:
            fitted = fit_growing(problem, state, start.periods, chosen.last)
        except _FAILURES as error:
            failure = str(error)
            continue
        if best is None or fitted.normal.chi2 < best.normal.chi2:
            best = fitted
        if best.normal.chi2 < _POOR_CHI2 * dof:
            break
    if best is None:
        raise RefusedError(Refusal.NO_CONVERGENCE, failure)
    return best


def _judged(problem: Problem, best: Fitted, chosen: SampleRange) -> FitResult:
    """Quality figures and the verdict."""
    record, model = problem.record, problem.model
    n = chosen.last - chosen.first
    window = record.samples[:, chosen.first : chosen.last]
    squares = float(best.normal.squares_by_channel.sum())
    r2 = 1.0 - squares / float(np.sum(window.var(axis=1)) * n)
    nrmse = math.sqrt(max(squares, 0.0) / float(np.sum(window**2)))
    dof = record.channels * n - int(problem.free.sum())
    chi2 = best.normal.chi2 / dof
    share = dof / record.channels
    by_channel = tuple(float(c) / share for c in best.normal.chi2_by_channel)
    if r2 < _UNEXPLAINED_R2 and chi2 > _POOR_CHI2:
        raise RefusedError(
            Refusal.MODEL_DOES_NOT_EXPLAIN, f"{model.name}: R2 = {r2:.4f}, chi2/dof = {chi2:.3g}"
        )
    state = by_convention(best.state)
    try:
        normal = problem.normal(state, chosen.last)
        public = publish(model, state, normal, problem.free)
    except _FAILURES as error:
        raise RefusedError(Refusal.OUT_OF_RANGE, str(error)) from error
    _refuse_untrustworthy(public)
    return FitResult(
        verdict="good",
        warnings=_warnings(public, chi2),
        notes=chosen.notes,
        parameters=public.parameters,
        covariance=public.covariance,
        covariance_names=public.names,
        r2=r2,
        nrmse=nrmse,
        chi2_per_dof=chi2,
        chi2_per_dof_by_channel=by_channel,
        window_s=chosen.last * record.dt_s,
        samples=n,
        iterations=problem.passes,
        fitted=FittedModel(model, state),
    )


def _refuse_untrustworthy(public: Published) -> None:
    """Numbers that are not finite or mean nothing beside their own error are no result."""
    if not np.all(np.isfinite(public.covariance)) or np.any(np.diag(public.covariance) <= 0.0):
        raise RefusedError(Refusal.NO_CONVERGENCE, "the covariance is not positive")
    estimates = public.parameters
    name, limit = "m_r_am2", _LARGEST_RELATIVE_STD
    if name not in estimates or estimates[name].std is None:
        name, limit = "phi_max_rad", _LARGEST_RELATIVE_STD_FREE_GAINS
    estimate = estimates[name]
    if estimate.std is not None and estimate.std > limit * abs(estimate.value):
        raise RefusedError(
            Refusal.AMPLITUDE_BELOW_FLOOR, f"{name} = {estimate.value:.4g} +- {estimate.std:.2g}"
        )
    friction = estimates.get("tf_over_i_rad_per_s2")
    if friction is not None and estimates["phi_max_rad"].value > 0.5 * math.pi:
        raise RefusedError(Refusal.OUT_OF_RANGE, "the Hertz contact holds below 90 degrees only")


def _warnings(public: Published, chi2: float) -> tuple[str, ...]:
    """Named doubts."""
    warnings = []
    if chi2 > 1.1:
        warnings.append("residual_not_white: the model leaves more than the noise")
    friction = public.parameters.get("tf_over_i_rad_per_s2")
    if friction is not None and friction.std is not None and friction.std > 0.2 * abs(friction.value):
        warnings.append("lambda_tf_not_separable: the friction is uncertain; fix lambda or lengthen the window")
    return tuple(warnings)

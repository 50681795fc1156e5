"""How precise a planned measurement can be: the Cramer-Rao bound in white noise, before anything is measured.

No unbiased estimator has a smaller scatter than the inverse Fisher matrix
    F_pq = sum over channels c and samples i of  (d y_ci/d p) (d y_ci/d q) / sd_c^2,
with a free constant offset per channel projected out, as in the fit. The derivatives are central differences of the
exact signal (eq:projection) by the public parameters: the fit's own analytic derivatives are not used, so that the
two check each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .least_squares.public_parameters import public_order
from .numerics.arrays import Array
from .parameters import RODRIGUES
from .physics.orbit import frequency_ratio
from .physics.quality import decay_time_s
from .physics.ring_down import RingDown
from .physics.rotation import cross_matrix, rodrigues_jacobian, rotation_from_rodrigues
from .physics.trajectory.basis_functions import DIPOLE
from .physics.trajectory.direct import Trajectory
from .screening.screening import refuse_few_periods, refuse_few_samples, refuse_slow_sampling

_PER_PERIOD = 64.0  # enough for every harmonic that matters; more samples only add up
_N50_S = 0.24


@dataclass(frozen=True)
class MeasurementPlan:
    """A measurement to come.

    Attributes:
        variant: "thread", "jewel" or any declared model.
        parameters: the expected values of all public parameters of that model (PARAMETER_NAMES, SI units).
        noise_sd: (3,) per world channel and sample, A m^2/s. For coloured noise: sqrt(psd(f) rate / 2), the sd of
            white noise of the same density at the fundamental.
        sampling_rate_hz: samples per second and channel.
        fixed: names that the fit will hold: f_nat_hz, m_r_am2 or coefficients of the model.
    """

    variant: str
    parameters: Mapping[str, float]
    noise_sd: Sequence[float] | Array
    sampling_rate_hz: float
    fixed: tuple[str, ...] = field(default=())


@dataclass(frozen=True)
class Precision:
    """The smallest standard deviations a window allows.

    Attributes:
        window_s: the window.
        sd: by public name, in its unit; fixed parameters are absent.
        orientation_rad: rms error angle of the orientation, sqrt of the trace of the rotation vector's covariance.
        names, covariance: (k,) and (k, k), of all free public parameters.
    """

    window_s: float
    sd: dict[str, float]
    orientation_rad: float
    names: tuple[str, ...]
    covariance: Array


def predict_precision(plan: MeasurementPlan, window_s: float) -> Precision:
    """Cramer-Rao bound of every public parameter for the samples in [0, window_s].

    Raises:
        ValueError: a fixed name that cannot be fixed, a window or noise that is not positive, or a window that does
            not determine the parameters at all.
        KeyError: a parameter of the model is missing in the plan.
        RefusedError: a record that a fit refuses: too few periods or samples, sampled too slowly.
    """
    _check(plan, window_s)
    _refuse_what_fits_refuse(plan, window_s)
    names, derivatives = _derivatives(plan, window_s)
    fisher = np.zeros((len(names), len(names)))
    represented = plan.sampling_rate_hz * window_s / derivatives.shape[2]
    for channel, sd in enumerate(plan.noise_sd):
        rows = derivatives[:, channel] - derivatives[:, channel].mean(axis=1, keepdims=True)
        fisher += represented / float(sd) ** 2 * rows @ rows.T
    local = _inverse(fisher)
    where = [names.index(n) for n in RODRIGUES]
    angle = math.sqrt(float(np.trace(local[np.ix_(where, where)])))
    jacobian = np.eye(len(names))
    jacobian[np.ix_(where, where)] = rodrigues_jacobian(_rodrigues(plan))
    covariance = jacobian @ local @ jacobian.T
    sd_by_name = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    return Precision(window_s, sd_by_name, angle, names, covariance)


def precision_table(plan: MeasurementPlan, windows_s: Iterable[float]) -> tuple[Precision, ...]:
    """The bound for each of several windows."""
    return tuple(predict_precision(plan, window) for window in windows_s)


def planned_window_s(plan: MeasurementPlan, window: str | float) -> float:
    """Seconds of "n50", "d30" (until 30 % of hat m_dot_v is left) or of the number itself.

    Raises:
        ValueError: another text, or a motion that never decays to 30 %.
    """
    if not isinstance(window, str):
        return float(window)
    if window == "n50":
        return _N50_S
    if window == "d30":
        return decay_time_s(RingDown.from_parameters(plan.variant, plan.parameters), 0.3)
    raise ValueError(f"window must be 'n50', 'd30' or seconds, not {window!r}")


def _check(plan: MeasurementPlan, window_s: float) -> None:
    """Refuse plans that mean nothing."""
    sd = np.asarray(plan.noise_sd, dtype=np.float64)
    if sd.shape != (3,) or not np.all(np.isfinite(sd)) or not np.all(sd > 0.0):
        raise ValueError(f"noise_sd must be three positive numbers, not {plan.noise_sd!r}")
    if not (math.isfinite(window_s) and window_s > 0.0 and plan.sampling_rate_hz > 0.0):
        raise ValueError(f"window {window_s!r} s and sampling rate {plan.sampling_rate_hz!r} Hz must be positive")
    unfixable = {*RODRIGUES, "phi_max_rad", "psi_start_rad"} & set(plan.fixed)
    if unfixable or not set(plan.fixed) <= set(plan.parameters):
        raise ValueError(f"only f_nat_hz, m_r_am2 and coefficients can be fixed, not {sorted(plan.fixed)}")


def _refuse_what_fits_refuse(plan: MeasurementPlan, window_s: float) -> None:
    """By the same limits."""
    frequency_hz = frequency_ratio(plan.parameters["phi_max_rad"]) * plan.parameters["f_nat_hz"]
    refuse_few_samples(int(plan.sampling_rate_hz * window_s))
    refuse_slow_sampling(plan.sampling_rate_hz, frequency_hz)
    refuse_few_periods(window_s, frequency_hz)


def _derivatives(plan: MeasurementPlan, window_s: float) -> tuple[tuple[str, ...], Array]:
    """Free names and d y/d p (names, 3, samples); the orientation by its local rotation vector."""
    steps = _steps(plan, window_s)
    rate = min(plan.sampling_rate_hz, _PER_PERIOD * plan.parameters["f_nat_hz"])
    samples = max(2, round(window_s * rate))
    rotation, moment = rotation_from_rodrigues(_rodrigues(plan)), plan.parameters["m_r_am2"]
    local = _local_signal(plan, {}, samples, window_s)
    rows = {"m_r_am2": rotation @ local}
    for axis, name in enumerate(RODRIGUES):
        rows[name] = moment * rotation @ cross_matrix(np.eye(3)[axis]) @ local
    for name, step in steps.items():
        up, down = (_local_signal(plan, {name: sign * step}, samples, window_s) for sign in (1.0, -1.0))
        rows[name] = moment * rotation @ (up - down) / (2.0 * step)
    names = tuple(sorted((n for n in rows if n not in plan.fixed), key=public_order))
    return names, np.stack([rows[n] for n in names])


def _local_signal(plan: MeasurementPlan, changes: Mapping[str, float], samples: int, window_s: float) -> Array:
    """dm/dt over m_r in local axes u, v, w: (3, samples)."""
    values = {name: value + changes.get(name, 0.0) for name, value in plan.parameters.items()}
    ring_down = RingDown.from_parameters(plan.variant, values)
    dt = window_s / samples
    basis = Trajectory(ring_down.model, ring_down.dynamics, window_s).basis(0, samples, dt, DIPOLE)
    return np.asarray(ring_down.dynamics.w * np.stack([basis[1], basis[0], np.zeros(samples)]))


def _steps(plan: MeasurementPlan, window_s: float) -> dict[str, float]:
    """Differences small against the curvature of the signal over the window, large against rounding."""
    small = 2e-4
    model = RingDown.from_parameters(plan.variant, plan.parameters).model
    amplitude, w = plan.parameters["phi_max_rad"], 2.0 * math.pi * plan.parameters["f_nat_hz"]
    steps = {"f_nat_hz": small / window_s, "phi_max_rad": 0.1 * small * amplitude, "psi_start_rad": small}
    for coefficient in model.coefficients:
        # A rate acts on the amplitude over the window's length, a torque through w.
        steps[coefficient.name] = small / window_s * (amplitude * w) ** (coefficient.power - 1)
    return steps


def _rodrigues(plan: MeasurementPlan) -> Array:
    return np.array([plan.parameters[name] for name in RODRIGUES])


def _inverse(fisher: Array) -> Array:
    """Inverse after scaling to unit diagonal.  Raises ValueError where the window does not determine everything."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(fisher), 1e-300))
    scaled = fisher * np.outer(scale, scale)
    if not np.all(np.isfinite(scaled)) or np.linalg.cond(scaled) > 1e12:
        raise ValueError("the window does not determine all parameters: lengthen it, or fix one")
    return np.asarray(np.linalg.inv(scaled) * np.outer(scale, scale))

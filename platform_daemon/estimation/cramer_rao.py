"""How precise a planned measurement can be: the Cramer-Rao bound in white noise, before anything is measured.

No unbiased estimator has a smaller scatter than the inverse Fisher matrix
    F_pq = sum over channels c and samples i of  (d y_ci/d p) (d y_ci/d q) / sd_c^2,
with a free constant offset per channel. It is the matrix of the fit's own normal equations at the expected parameters
(least_squares/gauss_newton.py); a test holds it against finite differences of the signal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .least_squares.constraints import free_mask
from .least_squares.gauss_newton import FitState, NormalEquations, covariance, normal_equations
from .least_squares.observation_model import DipoleObservation
from .least_squares.public_parameters import propagate_to_public
from .moments.workspace import Workspace
from .numerics.arrays import Array
from .parameters import RODRIGUES
from .physics.models import RingDownModel
from .physics.orbit import frequency_ratio
from .physics.quality import decay_time_s
from .physics.ring_down import RingDown
from .physics.rotation import rotation_from_rodrigues
from .screening.screening import refuse_few_periods, refuse_few_samples, refuse_slow_sampling
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.cramer_rao


@dataclass(frozen=True)
class MeasurementPlan:
    """A measurement to come.

    Attributes:
        variant: "thread", "jewel" or any declared model by name, or a model; what it holds, a fit will hold.
        parameters: the expected values of all public parameters of that model (PARAMETER_NAMES, SI units).
        noise_sd: (3,) per world channel and sample, A m^2/s. For coloured noise: sqrt(psd(f) rate / 2), the sd of
            white noise of the same density at the fundamental.
        sampling_rate_hz: samples per second and channel.
        fixed: further names that the fit will hold: f_nat_hz, m_r_am2 or coefficients of the model.
    """

    variant: str | RingDownModel
    parameters: Mapping[str, float]
    noise_sd: Sequence[float] | Array
    sampling_rate_hz: float
    fixed: tuple[str, ...] = field(default=())


@dataclass(frozen=True, kw_only=True)
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
    ring_down = RingDown.from_parameters(plan.variant, plan.parameters)
    rotation = rotation_from_rodrigues(np.array([plan.parameters[name] for name in RODRIGUES]))
    observation = DipoleObservation(plan.parameters["m_r_am2"], rotation, np.eye(3))
    state = FitState(ring_down.dynamics, observation, np.zeros(3))
    by_model = (p.name for p in ring_down.model.parameters.values() if p.fixed is not None)
    free = free_mask(ring_down.model, state.size, {*plan.fixed, *by_model})
    normal = _expected_normal_equations(plan, ring_down.model, state, window_s)
    internal, condition = covariance(normal, free)
    if not condition < LIMITS.largest_condition:
        raise ValueError("the window does not determine all parameters: lengthen it, or fix one")
    turned = np.cumsum(free)[_rotation_places(state)] - 1
    angle = math.sqrt(float(np.trace(internal[np.ix_(turned, turned)])))
    public = propagate_to_public(ring_down.model, state, normal, free)
    sd = dict(zip(public.names, np.sqrt(np.diag(public.covariance)).tolist(), strict=True))
    return Precision(window_s=window_s, sd=sd, orientation_rad=angle, names=public.names, covariance=public.covariance)


def _expected_normal_equations(
    plan: MeasurementPlan, model: RingDownModel, state: FitState, window_s: float
) -> NormalEquations:
    """Normal equations of a record that has this very state; its matrix is the Fisher matrix."""
    rate = min(plan.sampling_rate_hz, LIMITS.samples_per_period * plan.parameters["f_nat_hz"])
    samples = max(2, round(window_s * rate))
    if samples > LIMITS.most_samples:
        raise ValueError(
            f"the window holds {samples} samples, of which at most {LIMITS.most_samples} are computed: shorten it"
        )
    nothing, observable = np.zeros((3, samples)), state.observation.observable
    moments = Workspace(model).moments(state.dynamics, nothing, 0, samples, window_s / samples, observable)
    represented = plan.sampling_rate_hz * window_s / samples
    return normal_equations(model, state, moments, represented / np.asarray(plan.noise_sd, dtype=np.float64) ** 2)


def _rotation_places(state: FitState) -> slice:
    """Of the local rotation vector among the fit's parameters, behind the motion's and the moment."""
    first = 4 + len(state.dynamics.values)
    return slice(first, first + 3)


def planned_window_s(plan: MeasurementPlan, window: str | float) -> float:
    """Seconds of "n50", "d30" (until 30 % of hat m_dot_v is left) or of the number itself.

    Raises:
        ValueError: another text, or a motion that never decays to 30 %.
    """
    if not isinstance(window, str):
        return float(window)
    if window == "n50":
        return THRESHOLDS.screening.n50_s
    if window == "d30":
        return decay_time_s(RingDown.from_parameters(plan.variant, plan.parameters))
    raise ValueError(f"window must be 'n50', 'd30' or seconds, not {window!r}")


def rotor_samples(rx_s: float, sampling_rate_hz: float, f_nat_hz: float) -> tuple[int, float]:
    """How many samples of a rotor's record are computed, and their rate in Hz, no higher than matters.

    Raises ValueError for a record that is too long.
    """
    rate_hz = min(sampling_rate_hz, LIMITS.samples_per_period * f_nat_hz)
    samples = round(rx_s * rate_hz)
    if samples > LIMITS.most_rotor_samples:
        most_s = LIMITS.most_rotor_samples / rate_hz
        raise ValueError(f"it takes {samples} samples, and at most {most_s:.3g} s are computed")
    return samples, rate_hz


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

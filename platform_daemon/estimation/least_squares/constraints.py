"""What a model knows of its parameters before the fit: values held fixed, priors, bounds."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .gauss_newton import FitState, NormalEquations
from .observation_model import DipoleObservation
from .public_parameters import PublicParameters

LIMITS = THRESHOLDS.least_squares


def internal_index(model: RingDownModel, *, dipole: bool) -> dict[str, int]:
    """Places in the fit's parameter vector of the public parameters that it contains as they are (f_nat: as w)."""
    places = {"f_nat_hz": 1, **{c.name: 3 + k for k, c in enumerate(model.coefficients)}}
    if dipole:
        places["m_r_am2"] = 3 + len(model.coefficients)
    return places


def fixed_values(model: RingDownModel, fixed: Mapping[str, float] | None, *, dipole: bool) -> dict[str, float]:
    """Values of the parameters that are not fitted: those that the model holds, then those of the caller.

    Raises:
        ValueError: a parameter that the model lacks or that cannot be held, or a value outside its bounds.
    """
    places = internal_index(model, dipole=dipole)
    by_model = {p.name: p.fixed for p in model.parameters.values() if p.fixed is not None and p.name in places}
    for name, value in (fixed or {}).items():
        if name not in places:
            raise ValueError(f"{name} cannot be fixed for {model.name}: allowed are {', '.join(sorted(places))}")
        if not math.isfinite(value):
            raise ValueError(f"{name} is fixed to {value!r}, which is not a finite number")
        limits = model.parameters[name]
        if not limits.lower <= value <= limits.upper:
            raise ValueError(f"{name} is fixed to {value!r}, outside {limits.lower:g} .. {limits.upper:g}")
    return {**by_model, **(fixed or {})}


def free_mask(model: RingDownModel, size: int, fixed: Collection[str]) -> np.ndarray:
    """True for the internal parameters that are fitted, bool (size,)."""
    free = np.ones(size, dtype=bool)
    if fixed:
        places = internal_index(model, dipole=True)
        free[[place for name, place in places.items() if name in fixed]] = False
    return free


def with_fixed(state: FitState, model: RingDownModel, fixed: Mapping[str, float]) -> FitState:
    """The state with fixed values put in."""
    if not fixed:
        return state
    d = state.dynamics
    w = 2.0 * math.pi * fixed["f_nat_hz"] if "f_nat_hz" in fixed else d.w
    values = tuple(fixed.get(c.name, q) for c, q in zip(model.coefficients, d.values, strict=True))
    observation = state.observation
    if "m_r_am2" in fixed and isinstance(observation, DipoleObservation):
        observation = replace(observation, m_r=fixed["m_r_am2"])
    return FitState(replace(d, w=w, values=values), observation, state.offsets)


@dataclass(frozen=True, kw_only=True)
class Constraints:
    """Independent Gaussian knowledge of internal parameters: places, means and standard deviations, all (k,)."""

    places: tuple[int, ...] = ()
    mean: tuple[float, ...] = ()
    sd: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()

    def added(self, normal: NormalEquations, state: FitState) -> NormalEquations:
        """Normal equations that pull towards it; chi2 counts it like further data."""
        if not self.places:
            return normal
        d, m_r = state.dynamics, getattr(state.observation, "m_r", 0.0)
        value = np.array([0.0, d.w, 0.0, *d.values, m_r])
        places = np.array(self.places)
        precision = np.array(self.sd) ** -2.0
        miss = np.array(self.mean) - value[places]
        gradient, matrix = normal.gradient.copy(), normal.matrix.copy()
        gradient[places] += precision * miss
        matrix[places, places] += precision
        return replace(normal, chi2=normal.chi2 + float(precision @ miss**2), gradient=gradient, matrix=matrix)


def constraints_of(model: RingDownModel, fixed: Mapping[str, float], *, dipole: bool) -> Constraints:
    """The model's priors on the parameters that are fitted."""
    found, notes = [], []
    for name, place in internal_index(model, dipole=dipole).items():
        prior = model.parameters[name].prior
        if prior is not None and name not in fixed:
            scale = 2.0 * math.pi if name == "f_nat_hz" else 1.0
            found.append((place, scale * prior[0], scale * prior[1]))
            notes.append(f"prior: {name} = {prior[0]:g} +- {prior[1]:g}")
    places, mean, sd = zip(*found, strict=True) if found else ((), (), ())
    return Constraints(places=places, mean=mean, sd=sd, notes=tuple(notes))


def refuse_out_of_bounds(model: RingDownModel, public: PublicParameters, amplitude_rad: float) -> None:
    """Refuse a motion beyond the angle where the torques hold, and estimates significantly outside their bounds.

    amplitude_rad: the largest deflection in the window.
    """
    largest = model.largest_angle_rad
    if abs(amplitude_rad) >= largest:
        seen = f"{model.name}: the deflection reaches {math.degrees(abs(amplitude_rad)):.1f} deg"
        raise RefusedError(Refusal.CONTACT_LOST if largest < math.pi else Refusal.OUT_OF_RANGE, seen)
    for name, estimate in public.parameters.items():
        limits = model.parameters[name]
        slack = LIMITS.constraint_sigma * (estimate.std or 0.0)
        if not limits.lower - slack <= estimate.value <= limits.upper + slack:
            seen = f"{name} = {estimate.value:.4g} lies outside {limits.lower:g} .. {limits.upper:g} {limits.unit}"
            raise RefusedError(Refusal.OUT_OF_RANGE, seen)

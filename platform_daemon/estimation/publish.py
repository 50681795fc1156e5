"""From the fit's smooth internal parameters to the published ones, with the exact Jacobian."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .arrays import Array
from .gauss_newton import FitState, Normal, covariance
from .models import RingDownModel
from .result import PARAMETER_NAMES, Estimate
from .sampling import STATE
from .start_label import label_of_state
from .workspace import Workspace


@dataclass(frozen=True)
class Published:
    """Public parameters: estimates, covariance of the free ones, condition number of the scaled normal matrix."""

    parameters: dict[str, Estimate]
    names: tuple[str, ...]
    covariance: Array
    condition: float


def by_convention(state: FitState) -> FitState:
    """Resolve phi -> -phi so that the observation obeys its sign convention; the state itself if it does already."""
    observation, mirror = state.observation.by_convention()
    return replace(state, observation=observation).mirrored() if mirror else state


def publish(model: RingDownModel, state: FitState, normal: Normal, free: np.ndarray) -> Published:
    """Public values and covariance of a fitted state (already by convention); `normal` was taken at that state."""
    names, values, jacobian = _public_jacobian(model, state)
    internal, condition = covariance(normal, free)
    spread = jacobian[:, free]
    estimated = np.any(spread != 0.0, axis=1)
    matrix = spread[estimated] @ internal @ spread[estimated].T
    stds = iter(np.sqrt(np.diag(matrix)))
    parameters = {
        name: Estimate(float(value), float(next(stds)) if is_free else None)
        for name, value, is_free in zip(names, values, estimated, strict=True)
    }
    kept = tuple(n for n, is_free in zip(names, estimated, strict=True) if is_free)
    return Published(parameters, kept, matrix, condition)


def _public_jacobian(model: RingDownModel, state: FitState) -> tuple[list[str], Array, Array]:
    """Names, values (k,) and Jacobian (k, size) of all public parameters, in the public order."""
    d = state.dynamics
    coefficients = len(d.values)
    dynamic = 3 + coefficients
    # The products of the basis with one sample that is 1, at t = 0, are the basis there.
    basis = Workspace(model).moments(d, np.ones((1, 1)), 0, 1, 1.0, STATE).products[0]
    by_dynamics = basis[2 : 2 + 2 * dynamic].reshape(dynamic, 2).T @ d.chain(model)
    phi_max, psi, by_state = label_of_state(float(basis[0]), float(basis[1]))
    obs_names, obs_values, obs_jacobian = state.observation.public()

    rows: dict[str, tuple[float, Array]] = {}
    row = np.zeros(state.size)
    row[1] = 0.5 / math.pi
    rows["f_nat_hz"] = (d.w / (2.0 * math.pi), row)
    for k, coefficient in enumerate(model.coefficients):
        row = np.zeros(state.size)
        row[3 + k] = 1.0
        rows[coefficient.name] = (d.values[k], row)
    for k, (name, value) in enumerate((("phi_max_rad", phi_max), ("psi_start_rad", psi))):
        row = np.zeros(state.size)
        row[:dynamic] = by_state[k] @ by_dynamics
        rows[name] = (value, row)
    for k, name in enumerate(obs_names):
        row = np.zeros(state.size)
        row[dynamic : dynamic + state.observation.size] = obs_jacobian[k]
        rows[name] = (float(obs_values[k]), row)
    names = sorted(rows, key=_public_order)
    return names, np.array([rows[n][0] for n in names]), np.vstack([rows[n][1] for n in names])


def _public_order(name: str) -> tuple[int, str]:
    """Position in PARAMETER_NAMES; names of later terms come after them."""
    return (PARAMETER_NAMES.index(name) if name in PARAMETER_NAMES else len(PARAMETER_NAMES), name)

"""From the fit's smooth internal parameters to the published ones, with the exact Jacobian."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.parameters import PARAMETER_NAMES, Estimate
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.initial_conditions import initial_conditions_of_state
from platform_daemon.estimation.physics.trajectory.state_at_zero import state_at_zero
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .gauss_newton import FitState, NormalEquations, covariance

LIMITS = THRESHOLDS.least_squares
POOR_CHI2 = LIMITS.poor_chi2_per_dof


@dataclass(frozen=True, kw_only=True)
class PublicParameters:
    """Public parameters: estimates, covariance of the free ones, condition number of the scaled normal matrix."""

    parameters: dict[str, Estimate]
    names: tuple[str, ...]
    covariance: Array
    condition: float

    def widened(self, by: float) -> PublicParameters:
        """The same with so many times the variances."""
        if by == 1.0:
            return self
        root = math.sqrt(by)
        wider = {n: e if e.std is None else Estimate(e.value, root * e.std) for n, e in self.parameters.items()}
        stds = [wider[name].std for name in self.names]
        return replace(self, parameters=wider, covariance=_with_variances(by * self.covariance, np.array(stds)))


def by_convention(state: FitState, model: RingDownModel) -> FitState:
    """Resolve phi -> -phi so that the observation obeys its sign convention; the state itself if it does already."""
    observation, mirror = state.observation.by_convention()
    return replace(state, observation=observation).mirrored(model) if mirror else state


def propagate_to_public(
    model: RingDownModel, state: FitState, normal: NormalEquations, free: np.ndarray
) -> PublicParameters:
    """Public values and covariance of a fitted state (already by convention); `normal` was taken at that state."""
    names, values, jacobian = public_jacobian(model, state)
    internal, condition = covariance(normal, free)
    spread = jacobian[:, free]
    estimated: list[bool] = (spread != 0.0).any(axis=1).tolist()
    known = spread[estimated]
    matrix = known @ internal @ known.T
    stds = np.sqrt(matrix.diagonal())
    each = iter(stds.tolist())
    parameters = {
        name: Estimate(value, next(each) if is_free else None)
        for name, value, is_free in zip(names, values.tolist(), estimated, strict=True)
    }
    kept = tuple(name for name in names if parameters[name].std is not None)
    return PublicParameters(
        parameters=parameters, names=kept, covariance=_with_variances(matrix, stds), condition=condition
    )


def _with_variances(covariance: Array, stds: Array) -> Array:
    """The covariance whose diagonal is the square of these standard deviations to the last bit, as readers expect."""
    found = covariance.copy()
    np.fill_diagonal(found, stds * stds)
    return found


def refuse_faint(public: PublicParameters) -> None:
    """Refuse a size of the motion that is not larger than its own error."""
    estimates = public.parameters
    name, limit = "m_r_am2", LIMITS.faint_share
    if name not in estimates or estimates[name].std is None:
        name, limit = "phi_max_rad", LIMITS.faint_free_gain_share
    estimate = estimates[name]
    if estimate.std is not None and estimate.std > limit * abs(estimate.value):
        raise RefusedError(Refusal.AMPLITUDE_BELOW_FLOOR, f"{name} = {estimate.value:.4g} +- {estimate.std:.2g}")


def public_jacobian(model: RingDownModel, state: FitState) -> tuple[list[str], Array, Array]:
    """Names, values (k,) and Jacobian (k, size) of all public parameters, in the public order."""
    d = state.dynamics
    coefficients = len(d.values)
    dynamic = 3 + coefficients
    state_now, by_motion = state_at_zero(model, d)
    phi_max, psi, by_state = initial_conditions_of_state(*state_now.tolist())
    obs_names, obs_values, obs_jacobian = state.observation.public()

    names = ["f_nat_hz", *(c.name for c in model.coefficients), "phi_max_rad", "psi_start_rad", *obs_names]
    values = np.array([d.w / (2.0 * math.pi), *d.values, phi_max, psi, *obs_values])
    jacobian = np.zeros((len(names), state.size))
    jacobian[0, 1] = 0.5 / math.pi
    jacobian[1 : 1 + coefficients, 3:dynamic] = np.eye(coefficients)
    jacobian[1 + coefficients : 3 + coefficients, :dynamic] = by_state @ (by_motion.T @ d.chain(model))
    jacobian[dynamic:, dynamic : dynamic + state.observation.size] = obs_jacobian
    order = _order(tuple(names))
    return [names[k] for k in order], values[order], jacobian[order]


@cache
def _order(names: tuple[str, ...]) -> list[int]:
    """Places of the names in the public order."""
    return sorted(range(len(names)), key=lambda k: public_order(names[k]))


def public_order(name: str) -> tuple[int, str]:
    """Position in PARAMETER_NAMES; names of later terms come after them."""
    return (PARAMETER_NAMES.index(name) if name in PARAMETER_NAMES else len(PARAMETER_NAMES), name)

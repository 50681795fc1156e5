"""When a converged fit is still not to be believed."""

from __future__ import annotations

import numpy as np

from .models import RingDownModel
from .publish import Published
from .refusal import Refusal, RefusedError

POOR_CHI2 = 1.5  # per degree of freedom; beyond it other starts are tried
_UNEXPLAINED_R2 = 0.9
_SUSPECT_CHI2 = 2.0
_LARGEST_RELATIVE_STD = 0.05
_LARGEST_RELATIVE_STD_FREE_GAINS = 0.3
_UNSEPARATED = 0.2
_SEPARATED = 0.1  # relative error of the friction that separates it from the viscous loss
_SEPARATION_POWER = 1.0 / 2.7  # that error falls at least with the length of the window to the power of 2.7
_FEW_PERIODS = 12.0
_SURE = 5.0  # standard deviations


def refuse_unexplained(model_name: str, r2: float, chi2_per_dof: float) -> None:
    """Refuse a fit that leaves a tenth of the record's power."""
    if r2 < _UNEXPLAINED_R2 and chi2_per_dof > POOR_CHI2:
        raise RefusedError(
            Refusal.MODEL_DOES_NOT_EXPLAIN, f"{model_name}: R2 = {r2:.4f}, chi2/dof = {chi2_per_dof:.3g}"
        )


def is_suspect(chi2_per_dof: float) -> bool:
    """Bad enough to ask whether another declared model does far better."""
    return chi2_per_dof > _SUSPECT_CHI2


def refuse_wrong_variant(model_name: str, chi2_per_dof: float, other_name: str, other: float) -> None:
    """Refuse when a richer declared model explains what this one does not.

    A record with an undeclared small effect must pass (diagnosis starts from it), so the other model has to remove
    the misfit, or nine tenths of it.
    """
    if other < 0.1 * chi2_per_dof or (other < POOR_CHI2 and other < 0.5 * chi2_per_dof):
        raise RefusedError(
            Refusal.MODEL_DOES_NOT_EXPLAIN,
            f"{model_name}: chi2/dof = {chi2_per_dof:.3g}, while {other_name} reaches {other:.3g}",
        )


def refuse_untrustworthy(model: RingDownModel, public: Published) -> None:
    """Numbers that are not finite, or mean nothing beside their own error, are no result."""
    if not np.all(np.isfinite(public.covariance)) or np.any(np.diag(public.covariance) <= 0.0):
        raise RefusedError(Refusal.NO_CONVERGENCE, "the covariance is not positive")
    estimates = public.parameters
    name, limit = "m_r_am2", _LARGEST_RELATIVE_STD
    if name not in estimates or estimates[name].std is None:
        name, limit = "phi_max_rad", _LARGEST_RELATIVE_STD_FREE_GAINS
    estimate = estimates[name]
    if estimate.std is not None and estimate.std > limit * abs(estimate.value):
        raise RefusedError(Refusal.AMPLITUDE_BELOW_FLOOR, f"{name} = {estimate.value:.4g} +- {estimate.std:.2g}")
    losses = [estimates[n] for n in model.losses]
    if losses and all(e.std is not None and e.value < -_SURE * e.std for e in losses):
        raise RefusedError(Refusal.OUT_OF_RANGE, "the oscillation grows instead of decaying")


def doubts(
    model: RingDownModel, public: Published, chi2_per_dof: float, window_s: float, periods: float
) -> tuple[str, ...]:
    """Named warnings about a good result of a window of so many seconds and periods."""
    warnings = []
    if chi2_per_dof > 1.1:
        warnings.append("residual_not_white: the model leaves more than the noise")
    for name in model.losses:
        loss = public.parameters[name]
        if loss.std is not None and loss.value < -_SURE * loss.std:
            warnings.append(f"negative_loss: {name} = {loss.value:.4g} +- {loss.std:.2g} feeds energy in")
    friction = public.parameters.get("tf_over_i_rad_per_s2")
    viscous = public.parameters.get("lambda_per_s")
    if friction is not None and viscous is not None and friction.std is not None and viscous.std is not None:
        i, j = (public.names.index(n) for n in ("lambda_per_s", "tf_over_i_rad_per_s2"))
        correlation = public.covariance[i, j] / (viscous.std * friction.std)
        if abs(correlation) > 0.99 and friction.std > _UNSEPARATED * abs(friction.value):
            enough = window_s * (friction.std / (_SEPARATED * abs(friction.value))) ** _SEPARATION_POWER
            warnings.append(
                "lambda_tf_not_separable: the window determines only their sum; fix lambda, or lengthen the window "
                f"to about {enough:.2g} s"
            )
    if periods < _FEW_PERIODS:
        warnings.append(f"window_too_short: {periods:.1f} periods; the errors hold only if the model is exact")
    return tuple(warnings)

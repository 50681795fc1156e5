"""When a converged fit is still not to be believed."""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.least_squares.public_parameters import POOR_CHI2, PublicParameters, refuse_faint
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .collinearity import CollinearLosses, loss_warnings

LIMITS = THRESHOLDS.goodness_of_fit


def is_unexplained(r2: float, chi2_per_dof: float) -> bool:
    """True for a fit that leaves a tenth of the record's power, and more than noise."""
    return r2 < LIMITS.explained_r2 and chi2_per_dof > POOR_CHI2


def refuse_unexplained(model_name: str, r2: float, chi2_per_dof: float) -> None:
    """Refuse a fit that leaves a tenth of the record's power."""
    if is_unexplained(r2, chi2_per_dof):
        raise RefusedError(
            Refusal.MODEL_DOES_NOT_EXPLAIN, f"{model_name}: R2 = {r2:.4f}, chi2/dof = {chi2_per_dof:.3g}"
        )


def is_much_or_hidden(chi2: float, signal: float, dof: int) -> bool:
    """A fit leaves significantly more than noise, or has so much noise that a wrong variant would not.

    signal: the record's energy in units of the noise, of which a wrong variant leaves a share.
    """
    unseen = LIMITS.chi2_sigma * math.sqrt(2.0 * dof)
    return chi2 - dof > unseen or LIMITS.wrong_model_share * signal < unseen


def refuse_untrustworthy(model: RingDownModel, public: PublicParameters) -> None:
    """Numbers that are not finite, or are not larger than their own error, are no result."""
    if not (np.isfinite(public.covariance).all() and (public.covariance.diagonal() > 0.0).all()):
        raise RefusedError(Refusal.NO_CONVERGENCE, "the covariance is not positive")
    refuse_faint(public)
    estimates = public.parameters
    losses = [estimates[n] for n in model.losses]
    if losses and all(e.std is not None and e.value < -LIMITS.growth_sigma * e.std for e in losses):
        raise RefusedError(Refusal.OUT_OF_RANGE, "the oscillation grows instead of decaying")


def doubts(
    model: RingDownModel, public: PublicParameters, tangle: CollinearLosses | None, periods: float
) -> tuple[str, ...]:
    """Named warnings about the parameters of a good result of a window of so many periods."""
    warnings = [*loss_warnings(model, public, tangle)]
    if periods < LIMITS.few_periods:
        warnings.append(f"window_too_short: {periods:.1f} periods; the errors hold only if the model is exact")
    return tuple(warnings)

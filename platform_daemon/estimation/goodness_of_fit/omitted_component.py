"""How far a fit would move if a second oscillation were fitted with it, in linear approximation.

    r = J dp + sum over channels c of Re a_c w(t)

J are the derivatives by everything that is fitted. What the fit has absorbed of the second oscillation w is given back
to it: its size is the true one, not what is left of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

from .damped_sinusoid import DampedSinusoid, carrier, columns
from .residual_jacobian import LinearisedResidual

LIMITS = THRESHOLDS.goodness_of_fit


@dataclass(frozen=True, kw_only=True)
class ParameterShift:
    """A published parameter that moves: its value in the fit, the shift when the wave is fitted too, its error."""

    name: str
    value: float
    shift: float
    sd: float

    @property
    def share(self) -> float:
        """The shift over the value."""
        return self.shift / max(abs(self.value), 1e-300)

    def is_sure(self, standard_deviations: float) -> bool:
        """The shift is larger than so many of its errors."""
        return abs(self.shift) > standard_deviations * self.sd


@dataclass(frozen=True)
class OmittedComponent:
    """Size of the second oscillation over that of the fitted signal, both at the beginning; what moves."""

    relative: float
    moves: tuple[ParameterShift, ...]


def fit_with_component(given: LinearisedResidual, wave: DampedSinusoid) -> OmittedComponent:
    """Fit a wave of known shape and the parameters of the fit together to the residual."""
    channels, n = given.scaled.shape
    carried, _ = carrier(wave.shape, n, given.rate_hz)
    rows = np.concatenate([given.derivatives, columns(carried, channels)]).reshape(-1, channels * n)
    fitted, covariance = _solved(rows, given.scaled.ravel(), wave.noise)
    p = given.derivatives.shape[0]
    shifts = given.published @ fitted[:p]
    sds = np.sqrt((given.published @ covariance[:p, :p] * given.published).sum(axis=1))
    moves = tuple(
        ParameterShift(name=name, value=value, shift=shift, sd=sd)
        for name, value, shift, sd in zip(
            given.names, given.values.tolist(), shifts.tolist(), sds.tolist(), strict=True
        )
    )
    return OmittedComponent(_relative(fitted[p:], float(wave.shape[0]), given), moves)


def _solved(rows: Array, signal: Array, noise: float) -> tuple[Array, Array]:
    """Least squares by rows (k, m) and their covariance (k, k); what no data determine stays where it is."""
    norms = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
    left, values, right = np.linalg.svd(rows / norms[:, None], full_matrices=False)
    kept = values > LIMITS.component_share * values[0]
    spread = left[:, kept] / values[kept] / norms[:, None]
    return spread @ (right[kept] @ signal), noise * spread @ spread.T


def _relative(amplitudes: Array, frequency_hz: float, given: LinearisedResidual) -> float:
    """Size of an oscillation with these amplitudes (2 channels,) over that of the fitted signal at its beginning."""
    early = (
        given.motion[:, : max(LIMITS.early_means, given.motion.shape[1] // LIMITS.early_divisor)] * given.sd[:, None]
    )
    main = float(np.sqrt(2.0 * np.mean(early**2, axis=1).sum()))
    # Means of blocks show fast oscillations smaller than they are.
    seen, of_main = np.sinc(frequency_hz / given.rate_hz), np.sinc(given.fundamental_hz / given.rate_hz)
    return float(np.linalg.norm(amplitudes * np.tile(given.sd, 2)) / seen / (main / of_main))

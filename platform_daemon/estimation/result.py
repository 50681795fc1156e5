"""What a fit returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from .least_squares.gauss_newton import FitState
from .numerics.arrays import Array
from .parameters import Estimate
from .physics.models import RingDownModel
from .physics.ring_down import RingDown
from .physics.trajectory.direct import Trajectory
from .refusal import Refusal, RefusedError


@dataclass(frozen=True)
class FittedModel:
    """The fitted model in its internal, smooth parameters.

    sd: (channels, 2) standard deviations that odd and even harmonics were weighted by; None: it was not fitted.
    """

    model: RingDownModel
    state: FitState
    sd: Array | None = field(default=None, compare=False)


@dataclass(frozen=True)
class FitResult:
    """Result of one ring-down fit.

    Attributes:
        verdict: "good" or "refused"; refused results carry no numbers.
        reason: why it was refused, beginning with the code's name; None if good.
        code: the code of the refusal; None if good.
        warnings: named doubts about a good result.
        notes: where the fit differs from the request.
        parameters: estimates by public name (PARAMETER_NAMES); what the model lacks is absent.
        covariance: (k, k), order covariance_names: the free parameters only; its diagonal is std * std exactly.
        r2, nrmse: pooled over channels without weights; nrmse = rms residual / rms signal.
        chi2_per_dof, chi2_per_dof_by_channel: against the independently measured noise.
        whiteness_by_channel: spectral flatness of the residual up to ten times the fundamental, against the colour of
            the noise: 1 for noise alone, near 0 where something is left over.
        condition: number of the normal equations, scaled to unit diagonal.
        inseparable: the two losses of which the window determines the sum only, if there are such.
        window_s: fitted time span from t = 0; samples: per channel; seconds: computing time; iterations: passes
            over samples.
        systematic_std: by public name, the standard uncertainty that comes from the calibration alone: the same error
            in all frames, not in std and covariance; empty where the calibration does not say how true it is.
        noise_source: where the noise was measured; noise_seconds: what that took, not in `seconds`.
    """

    verdict: Literal["good", "refused"]
    reason: str | None = None
    code: Refusal | None = None
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    parameters: dict[str, Estimate] = field(default_factory=dict)
    covariance: Array = field(default_factory=lambda: np.empty((0, 0)))
    covariance_names: tuple[str, ...] = ()
    r2: float | None = None
    nrmse: float | None = None
    chi2_per_dof: float | None = None
    chi2_per_dof_by_channel: tuple[float, ...] | None = None
    whiteness_by_channel: tuple[float, ...] | None = None
    condition: float | None = None
    inseparable: tuple[str, ...] = ()
    window_s: float | None = None
    samples: int = 0
    seconds: float = 0.0
    iterations: int = 0
    noise_source: str | None = None
    noise_seconds: float = 0.0
    fitted: FittedModel | None = None
    systematic_std: dict[str, float] = field(default_factory=dict)

    @classmethod
    def refused(cls, why: RefusedError) -> FitResult:
        """The result that says why there is none."""
        return cls("refused", reason=str(why), code=why.code)

    def is_fixed(self, name: str) -> bool:
        """True for a parameter of a good result that was held, not estimated."""
        return name in self.parameters and self.parameters[name].std is None

    def ring_down(self) -> RingDown:
        """The fitted motion and its moment.  Raises ValueError if the fit was refused."""
        if self.fitted is None:
            raise ValueError("a refused fit describes no ring-down")
        moment = self.parameters.get("m_r_am2")
        return RingDown(self.fitted.model, self.fitted.state.dynamics, None if moment is None else moment.value)

    def model_signal(self, n_samples: int, sampling_rate_hz: float) -> Array:
        """The fitted model at t = 0, 1/rate, ..., (channels, n_samples), also past the window.

        Raises:
            ValueError: the fit was refused.
        """
        if self.fitted is None:
            raise ValueError("a refused fit has no model signal")
        state = self.fitted.state
        dt = 1.0 / sampling_rate_hz
        trajectory = Trajectory(self.fitted.model, state.dynamics, n_samples * dt)
        basis = trajectory.basis(0, n_samples, dt, state.observation.observable)
        gains = state.observation.gains(state.dynamics.w)
        return np.asarray(gains @ basis[:2] + state.offsets[:, None])


def model_signal(result: FitResult, n_samples: int, sampling_rate_hz: float) -> Array:
    """See FitResult.model_signal."""
    return result.model_signal(n_samples, sampling_rate_hz)

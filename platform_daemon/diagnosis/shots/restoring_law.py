"""Whether swings whose system nobody named are those of a pendulum or of a torsion spring.

A wide swing tells: the frequency of a pendulum, whose restoring torque goes with sin(phi), rises by phi_max^2 / 16 as
it dies, and that of a spring stays.  Against a pendulum the spring would have to be an effect as large as the declared
torque itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.models import RingDownModel

from .initial_fits import initial_fits
from .linearisation import linearise_signal
from .shot import DiagnosisShot

_LIMITS = THRESHOLDS.shots


def is_of_spring(shots: Sequence[DiagnosisShot], pendulum: RingDownModel, spring: RingDownModel) -> bool:
    """True if a linear restoring torque leaves far less of all angles than sin(phi) does."""
    by_sine, by_spring = (_left(shots, model) for model in (pendulum, spring))
    return by_spring < _LIMITS.spring_share * by_sine


def _left(shots: Sequence[DiagnosisShot], model: RingDownModel) -> float:
    """chi^2 of all shots; infinite where one cannot be fitted."""
    prepared, refused = initial_fits(shots, model, None)
    if refused:
        return np.inf
    return float(sum(np.sum(linearise_signal(p, model, p.state).whitened ** 2) for p in prepared))

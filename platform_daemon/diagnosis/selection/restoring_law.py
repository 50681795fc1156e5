"""Whether swings whose system nobody named are those of a pendulum or of a torsion spring.

A wide swing tells: the frequency of a pendulum, whose restoring torque goes with sin(phi), rises by phi_max^2 / 16 as
it dies, and that of a spring stays.  Against a pendulum the spring would have to be an effect as large as the declared
torque itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.linearisation import linearise_signal
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .data_integrity import after_clipping
from .stale_samples import without_stale_samples

_LIMITS = THRESHOLDS.shots


def is_of_spring(shots: Sequence[DiagnosisShot], pendulum: RingDownModel, spring: RingDownModel) -> bool:
    """True if a linear restoring torque leaves far less than sin(phi) does, of all angles that both can be fitted to.

    shots: as they were read; what is clipped or stale of them is left out first.
    """
    whole, _ = without_stale_samples([after_clipping(shot, k)[0] for k, shot in enumerate(shots)])
    left = [(_left(shot, spring), _left(shot, pendulum)) for shot in whole]
    both = np.array([pair for pair in left if np.isfinite(pair).all()]).reshape(-1, 2)
    by_spring, by_sine = both.sum(axis=0)
    return bool(by_spring < _LIMITS.spring_share * by_sine)


def _left(shot: DiagnosisShot, model: RingDownModel) -> float:
    """chi^2; infinite where it cannot be fitted."""
    prepared, _ = initial_fits([shot], model, None)
    try:
        return float(sum(np.sum(linearise_signal(p, model, p.state).whitened ** 2) for p in prepared) or np.inf)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return float(np.inf)

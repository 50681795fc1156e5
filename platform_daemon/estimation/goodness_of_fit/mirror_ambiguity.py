"""Do the data say which of a motion's two twins is published?

phi -> -phi together with a half turn about e_u gives the same dm/dt. The convention e_v . x > 0 picks one; where e_v is
perpendicular to x within its error, noise does.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.least_squares.observation_model import DipoleObservation, Observation
from platform_daemon.estimation.least_squares.public_parameters import PublicParameters
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.rotation import rodrigues_jacobian
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.goodness_of_fit


def mirror_warnings(observation: Observation, public: PublicParameters) -> tuple[str, ...]:
    """A warning if noise decides which twin is published."""
    if not isinstance(observation, DipoleObservation):
        return ()
    side = float(observation.rotation[0, 1])
    stds = [public.parameters[name].std or 0.0 for name in RODRIGUES]
    # A rotation vector changes by at least as much as the rotation.
    if abs(side) > LIMITS.mirror_sigma * math.hypot(*stds):
        return ()
    std = _side_std(observation, public)
    if abs(side) > LIMITS.mirror_sigma * std:
        return ()
    return (
        f"twin_undecided: e_v . x = {side:.2g} +- {std:.2g}: noise decides between this motion and its exact twin, "
        "phi -> -phi (psi_start + 180 deg) turned by 180 deg about e_u",
    )


def _side_std(observation: DipoleObservation, public: PublicParameters) -> float:
    """Standard deviation of e_v . x; R exp([delta]x) moves it by delta_u R_xw - delta_w R_xu."""
    rodrigues = np.array([public.parameters[name].value for name in RODRIGUES])
    r_xu, _, r_xw = observation.rotation[0].tolist()
    by_vector = np.linalg.solve(rodrigues_jacobian(rodrigues).T, np.array([r_xw, 0.0, -r_xu]))
    places = [public.names.index(name) for name in RODRIGUES]
    return math.sqrt(float(by_vector @ public.covariance[np.ix_(places, places)] @ by_vector))

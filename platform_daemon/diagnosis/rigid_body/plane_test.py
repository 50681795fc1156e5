"""The plane test: a rotor of one angle moves its moment in the plane across its axis, and dm/dt has no part along it.

Crosstalk and a tilted frame bring parts of the other two there; a component proportional to the data across the axis is
taken out, as far as one constant factor for each can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.rigid_body


@dataclass(frozen=True, kw_only=True)
class PlaneTest:
    """Of each shot: power along the main axis over that of noise alone (1: none), its standard deviation, and the rms
    of the motion there over that of the whole signal."""

    ratio: tuple[float, ...]
    sd: tuple[float, ...]
    share: tuple[float, ...]

    @property
    def leaves(self) -> bool:
        """The motion leaves its plane, in every shot."""
        far = (r > 1.0 + _LIMITS.plane_sigma * s for r, s in zip(self.ratio, self.sd, strict=True))
        return all(far) and min(self.share) > _LIMITS.plane_share


def plane_test(base: JointFit) -> PlaneTest | None:
    """Of the fits of the declared model; None for what is not dm/dt in world axes."""
    if base.prepared[0].shot.record.quantity != "dmdt":
        return None
    rows = []
    for prepared, state in zip(base.prepared, base.states, strict=True):
        observed = state.observation
        if not isinstance(observed, DipoleObservation):
            return None
        rows.append(_of_shot(prepared.shot.record.valid, observed.rotation, prepared.shot.noise.sd))
    ratio, sd, share = zip(*rows, strict=True)
    return PlaneTest(ratio=ratio, sd=sd, share=share)


def _of_shot(samples: Array, rotation: Array, noise_sd: Array) -> Sequence[float]:
    """Ratio, its standard deviation, share."""
    along, across = rotation[:, 2] @ samples, rotation[:, :2].T @ samples
    basis = np.vstack([across, np.ones(samples.shape[1])])
    left = along - np.linalg.lstsq(basis.T, along, rcond=None)[0] @ basis
    level = float(rotation[:, 2] ** 2 @ noise_sd**2)
    power, n = float(left @ left), left.size
    share = float(np.sqrt(max(power / n - level, 0.0) / np.mean(np.sum(samples**2, axis=0))))
    return power / (n * level), float(np.sqrt(2.0 / n)), share

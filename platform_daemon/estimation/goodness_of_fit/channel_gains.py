"""Does a misfit look like gains of the channels, and crosstalk between them, that differ from the calibration?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.thresholds import THRESHOLDS

from .residual_jacobian import LinearisedResidual, orthonormal, projected_out

LIMITS = THRESHOLDS.goodness_of_fit


@dataclass(frozen=True)
class ChannelGains:
    """Gains and crosstalk that explain a misfit.

    share: of the misfit's power that they explain, 0 to 1; largest: the largest change of a gain, or crosstalk, 1.
    """

    share: float
    largest: float


def find_channel_gains(given: LinearisedResidual) -> ChannelGains | None:
    """The gains and the crosstalk that explain most of a misfit; None: they do not, or there is one channel only.

    A resonator beside the place for which the sensitivity was calibrated looks like this: orientation and moment take
    up a rotation and a common factor of the sensitivity, and everything else of its change is left over.
    """
    channels, points = given.motion.shape
    known = orthonormal(given.derivatives)
    left = projected_out(given.scaled, known)
    misfit = float(np.sum(left**2)) - left.size
    if channels < 2 or misfit <= 0.0:
        return None
    changes = np.zeros((channels, channels, channels, points))
    for to in range(channels):
        changes[to, :, to] = given.motion * given.sd[:, None] / given.sd[to]
    freed = np.stack([projected_out(change, known).ravel() for change in changes.reshape(-1, channels, points)])
    sizes, *_ = np.linalg.lstsq(freed.T, left.ravel(), rcond=LIMITS.gain_rank_share)
    share = float(np.sum((sizes @ freed) ** 2)) / misfit
    if share < LIMITS.gain_share:
        return None
    return ChannelGains(share=min(share, 1.0), largest=float(np.abs(sizes).max()))

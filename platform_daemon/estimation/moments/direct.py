"""Moments of a window by the direct path: the basis itself, sample by sample. Slow, and good for any torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.least_squares


@dataclass(frozen=True, kw_only=True)
class Moments:
    """Sufficient statistics of a window: gram (b, b), products (channels, b), energy (channels,) = sum y^2.

    samples: per channel, that took part. slopes: d S/d (A, c) of the last turning point S, (columns,).
    """

    gram: Array
    products: Array
    energy: Array
    samples: int
    slopes: Array

    def followed_by(self, later: Moments) -> Moments:
        """Of both stretches."""
        return Moments(
            gram=self.gram + later.gram,
            products=self.products + later.products,
            energy=self.energy + later.energy,
            samples=self.samples + later.samples,
            slopes=later.slopes,
        )


def direct_moments(
    model: RingDownModel, dynamics: MotionParameters, y: Array, first: int, last: int, dt_s: float, observable: int
) -> Moments:
    """Moments of samples first .. last-1.

    Raises:
        LostTrajectoryError: the parameters describe no oscillation.
    """
    trajectory = Trajectory(model, dynamics, (last - 1) * dt_s)
    b = 7 + 2 * (1 + len(model.coefficients))
    gram, products, energy = np.zeros((b, b)), np.zeros((y.shape[0], b)), np.zeros(y.shape[0])
    for begin in range(first, last, LIMITS.direct_chunk_samples):
        stop = min(begin + LIMITS.direct_chunk_samples, last)
        basis = trajectory.basis(begin, stop, dt_s, observable)
        piece = y[:, begin:stop]
        gram += basis @ basis.T
        products += piece @ basis.T
        energy += np.sum(piece**2, axis=1)
    return Moments(gram=gram, products=products, energy=energy, samples=last - first, slopes=trajectory.slopes())

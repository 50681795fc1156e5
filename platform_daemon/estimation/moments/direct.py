"""Moments of a window by the direct path: the basis itself, sample by sample. Slow, and good for any torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..numerics.arrays import Array
from ..physics.models import RingDownModel
from ..physics.trajectory.direct import MotionParameters, Trajectory

_CHUNK = 4096  # samples whose basis is in memory at once


@dataclass(frozen=True)
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
            self.gram + later.gram,
            self.products + later.products,
            self.energy + later.energy,
            self.samples + later.samples,
            later.slopes,
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
    for begin in range(first, last, _CHUNK):
        stop = min(begin + _CHUNK, last)
        basis = trajectory.basis(begin, stop, dt_s, observable)
        piece = y[:, begin:stop]
        gram += basis @ basis.T
        products += piece @ basis.T
        energy += np.sum(piece**2, axis=1)
    return Moments(gram, products, energy, last - first, trajectory.slopes())

"""A receiver that compresses: its output falls behind the motion with odd powers of it, the same at every time.

A torque that the model lacks cannot do that: it changes the fundamental, and hardly its third harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .residual_jacobian import LinearisedResidual, fitted_subspace, noise_power, projected_out

_POWERS = (3, 5)


@dataclass(frozen=True)
class Compression:
    """What odd powers of the fitted motion explain of a misfit.

    Attributes:
        share: of the misfit's power.
        channel: the one that is bent most.
        at_peak: by which its output falls behind a straight line at the peak of the motion, relative to it.
    """

    share: float
    channel: int
    at_peak: float


def find_compression(given: LinearisedResidual) -> Compression | None:
    """Powers of each channel's own motion, added to the fit in linear approximation; None: nothing is left over."""
    channels = given.scaled.shape[0]
    known = fitted_subspace(given)
    left = projected_out(given.scaled, known)
    noise = noise_power(left)
    misfit = float(np.sum(left**2)) - noise * left.size
    peaks = np.max(np.abs(given.motion), axis=1)
    if misfit <= 0.0 or not np.all(peaks > 0.0):
        return None
    shape = given.motion / peaks[:, None]
    powers = [np.eye(channels)[:, :, None] * (peaks[:, None] * shape**p)[:, None, :] for p in _POWERS]
    rows = np.stack([projected_out(power, known).ravel() for power in np.concatenate(powers)])
    bends, *_ = np.linalg.lstsq(rows.T, left.ravel(), rcond=None)
    gain = float(np.sum((bends @ rows) ** 2))
    at_peak = -bends.reshape(len(_POWERS), channels).sum(axis=0)
    worst = int(np.argmax(np.abs(at_peak) * peaks))
    return Compression((gain - bends.size * noise) / misfit, worst, float(at_peak[worst]))

"""Flat tops under noise that was added after them, distinguished from everything else that a fit can leave over.

What is cut off a channel's motion beyond a level is missing from the record, all of it: the residual is the excess of
the motion over that level, with the sign of a loss and a factor near one. No torque and no gain has that shape.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

from .residual_jacobian import LinearisedResidual, fitted_subspace, noise_power, projected_out

LIMITS = THRESHOLDS.goodness_of_fit
_CUTS = LIMITS.cut_first_share * LIMITS.cut_step ** np.arange(LIMITS.cut_count)
PERIODS = LIMITS.cut_periods

_SIDES = {"top": (1.0,), "bottom": (-1.0,), "top and bottom": (1.0, -1.0)}


@dataclass(frozen=True, kw_only=True)
class FlatTop:
    """A channel whose motion is cut off.

    Attributes:
        channel, side: where.
        share: of the misfit's power that this explains.
        cut: what is missing at the peak of the motion, relative to it.
    """

    channel: int
    side: str
    share: float
    cut: float


def find_flat_tops(given: LinearisedResidual) -> FlatTop | None:
    """The channel, side and level that explain most of a misfit; None if what is left over is not an excess."""
    known = fitted_subspace(given)
    left = projected_out(given.scaled, known)
    noise = noise_power(left)
    misfit = float(np.sum(left**2)) - noise * left.size
    found: list[tuple[float, FlatTop]] = []
    for channel, side, cut, excess in _candidates(given.motion):
        shape = projected_out(excess, known)
        power = float(np.vdot(shape, shape))
        factor = -float(np.vdot(shape, left)) / max(power, 1e-300)
        gain = factor**2 * power
        if LIMITS.cut_factor[0] < factor < LIMITS.cut_factor[1] and gain > LIMITS.cut_chi2 * noise:
            found.append((gain, FlatTop(channel=channel, side=side, share=gain / max(misfit, gain), cut=cut)))
    return max(found, key=lambda one: one[0])[1] if found else None


def _candidates(motion: Array) -> Iterator[tuple[int, str, float, Array]]:
    """(channel, side, cut, what is beyond the level (channels, n)) of motions (channels, n)."""
    for channel, row in enumerate(motion):
        peak = float(np.abs(row).max())
        for cut in _CUTS:
            level = (1.0 - cut) * peak
            for side, signs in _SIDES.items():
                excess = np.zeros_like(motion)
                for sign in signs:
                    excess[channel] += sign * np.maximum(sign * row - level, 0.0)
                yield channel, side, float(cut), excess

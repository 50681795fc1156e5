"""Clipping, seen in the samples as the converter gave them."""

from __future__ import annotations

import numpy as np

from .arrays import Array

_FEWEST = 16
_CROWD = 5.0


def saturation(samples: Array) -> str | None:
    """Why these samples are clipped, None if they are not; samples: (channels, n), raw, in any unit.

    A clipped signal piles up at its largest or smallest value: that one value occurs far more often than the next one
    below it. A smooth peak does not, neither in floating point (values hardly repeat) nor after coarse quantisation
    (the level at the top of a sine is held about as often as the next). Judge raw samples: filters and mixing of
    channels smear the pile.
    """
    for channel, y in enumerate(np.asarray(samples)):
        for side, values in (("top", y), ("bottom", -y)):
            piled, below = _crowd(values)
            if piled >= _FEWEST and piled > _CROWD * max(below, 1):
                return f"{piled} samples of channel {channel} pile up at its {side}"
    return None


def _crowd(y: Array) -> tuple[int, int]:
    """How often the largest value occurs, and how often the next smaller one."""
    if not np.isfinite(y).all() or not y.size:
        return 0, 0
    largest = float(y.max())
    rest = y[y < largest]
    if not rest.size:
        return 0, 0
    return y.size - rest.size, int(np.count_nonzero(rest == rest.max()))

"""Clipping, seen in the samples as the converter gave them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..numerics.arrays import Array

_FEWEST = 16
_FEW = 6
_CROWD = 5.0


@dataclass(frozen=True)
class Clipping:
    """Samples of a channel that pile up at its top or bottom."""

    samples: int
    channel: int
    side: str

    @property
    def severe(self) -> bool:
        """Too many for a fit to be right."""
        return self.samples >= _FEWEST

    def __str__(self) -> str:
        return f"{self.samples} samples of channel {self.channel} pile up at its {self.side}"


def saturation(samples: Array) -> str | None:
    """Why these samples are too clipped for a fit, None if they are not; samples: (channels, n), raw, in any unit."""
    found = find_clipping(samples)
    return str(found) if found is not None and found.severe else None


def find_clipping(samples: Array) -> Clipping | None:
    """The largest pile of clipped samples, None if there is none; samples: (channels, n), raw, in any unit.

    A clipped signal piles up at its largest or smallest value: that one value occurs far more often than the next one
    below it. A smooth peak does not, neither in floating point (values hardly repeat) nor after coarse quantisation
    (the level at the top of a sine is held about as often as the next). Judge raw samples: filters and mixing of
    channels smear the pile.
    """
    found = []
    for channel, y in enumerate(np.asarray(samples)):
        for side, values in (("top", y), ("bottom", -y)):
            piled, below = _crowd(values)
            if piled >= _FEW and piled > _CROWD * max(below, 1):
                found.append(Clipping(piled, channel, side))
    return max(found, key=lambda clipping: clipping.samples, default=None)


def _crowd(y: Array) -> tuple[int, int]:
    """How often the largest value occurs, and how often the next smaller one."""
    if not np.isfinite(y).all() or not y.size:
        return 0, 0
    largest = float(y.max())
    rest = y[y < largest]
    if not rest.size:
        return 0, 0
    return y.size - rest.size, int(np.count_nonzero(rest == rest.max()))

"""What the converters of one shot recorded, block by block, as far back as the cards' ring reaches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend.world.shot import ShotResult

CHANNELS = 3
RING = 2**25


class SampleRing:
    """Blocks in order, without gaps: first sample, and the leg whose samples they are."""

    def __init__(self) -> None:
        self._blocks: list[tuple[int, ShotResult]] = []

    def add(self, first: int, leg: ShotResult) -> None:
        """Append what follows."""
        self._blocks.append((first, leg))
        while len(self._blocks) > 1 and self._blocks[1][0] < first - RING:
            del self._blocks[0]

    def read(self, first: int, stop: int) -> NDArray[np.float32]:
        """Samples first..stop, zero where there are none: (3, stop - first) float32, V."""
        out = np.zeros((CHANNELS, stop - first), dtype=np.float32)
        ends = [start for start, _ in self._blocks[1:]] + [stop]
        for (start, leg), end in zip(self._blocks, ends, strict=False):
            if start >= stop or end <= first:
                continue
            volts = leg.received.volts
            a, b = max(first, start), min(stop, start + volts.shape[1])
            if a < b:
                out[:, a - first : b - first] = volts[:, a - start : b - start]
        return out

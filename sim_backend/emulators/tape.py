"""What the converters of one shot recorded, block by block, as far back as the cards' ring reaches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CHANNELS = 3
RING = 2**25


class Tape:
    """Blocks (first sample, (3, n) float32 V) in order, without gaps."""

    def __init__(self) -> None:
        self._blocks: list[tuple[int, NDArray[np.float32]]] = []

    def add(self, first: int, volts: NDArray[np.float32]) -> None:
        """Append what follows."""
        self._blocks.append((first, volts))
        while self._blocks[0][0] + self._blocks[0][1].shape[1] < first + volts.shape[1] - RING:
            del self._blocks[0]

    def read(self, first: int, stop: int) -> NDArray[np.float32]:
        """Samples first..stop, zero where there are none: (3, stop - first) float32, V."""
        out = np.zeros((CHANNELS, stop - first), dtype=np.float32)
        for start, volts in self._blocks:
            a, b = max(first, start), min(stop, start + volts.shape[1])
            if a < b:
                out[:, a - first : b - first] = volts[:, a - start : b - start]
        return out

"""Samples at an end of the converter's range are not what was at the input; looked for while they come in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.io_card import CardCapabilities

AT_THE_END = 5e-4  # of the range: the decimation filters round the corners of what the converter cut off


class ConverterRangeCheck:
    """Counts them, input by input."""

    def __init__(self, card: CardCapabilities) -> None:
        self._ranges_v = [card.input_range_v(k) for k in range(card.inputs)]
        self._counts = [0] * card.inputs

    def see(self, volts: NDArray[np.float32]) -> None:
        """Samples of the RX window, (inputs, n) V."""
        for channel, (u, (low_v, high_v)) in enumerate(zip(volts, self._ranges_v, strict=True)):
            margin_v = AT_THE_END * (high_v - low_v)
            beyond = np.count_nonzero(u <= low_v + margin_v) + np.count_nonzero(u >= high_v - margin_v)
            self._counts[channel] += int(beyond)

    def verdict(self) -> str | None:
        """Why the samples seen must not be used, None if the converter could follow."""
        for channel, (count, (low_v, high_v)) in enumerate(zip(self._counts, self._ranges_v, strict=True)):
            if count:
                return (
                    f"{count} samples of input {channel} are at an end of its range, {low_v:.3g} V ... {high_v:.3g} V"
                )
        return None

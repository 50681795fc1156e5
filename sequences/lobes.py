"""The course of the excitation field as half periods between its zeros: any law of phase, of either shape."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sequences.request import SequenceRequest, Waveform

ALMOST = 1e-9  # of a half period: rounding of its ends


@dataclass(frozen=True)
class Lobes:
    """A field that changes its sign at `zeros_s`, (n + 1,) s from the start of TX, strictly rising.

    The first zero may lie before TX, which then begins inside a half period.  first_sign: of the first half period, +1
    or -1, the following signs alternate.  The field is zero after the last zero.
    """

    zeros_s: NDArray[np.float64]
    first_sign: int
    waveform: Waveform = "sine"
    duty: float = 1.0

    def __len__(self) -> int:
        return len(self.zeros_s) - 1

    def signs(self) -> NDArray[np.float64]:
        """Sign of every half period, (n,)."""
        return np.asarray(self.first_sign * (-1.0) ** np.arange(len(self)))

    def mean_hz(self) -> float:
        """Frequency, averaged over the half periods, Hz; 0 without any."""
        return 0.5 * len(self) / float(self.zeros_s[-1] - self.zeros_s[0]) if len(self) else 0.0

    def until(self, stop_s: float) -> Lobes:
        """The half periods that end by `stop_s`."""
        return replace(self, zeros_s=self.zeros_s[self.zeros_s <= stop_s * (1 + ALMOST)])

    def at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The field at times (m,) in units of its amplitude, (m,)."""
        if not len(self):
            return np.zeros(times_s.shape)
        k = np.searchsorted(self.zeros_s, times_s, side="right") - 1
        inside = (k >= 0) & (k < len(self))
        k = np.clip(k, 0, len(self) - 1)
        place = (times_s - self.zeros_s[k]) / np.diff(self.zeros_s)[k]
        return np.where(inside, self.signs()[k] * half_period(place, self.waveform, self.duty), 0.0)


def half_period(place: NDArray[np.float64], waveform: Waveform, duty: float) -> NDArray[np.float64]:
    """Shape of one half period at places 0 to 1 in it: the arch of a sine, or 1 in the middle share `duty`."""
    if waveform == "sine":
        return np.asarray(np.sin(np.pi * place))
    return np.where(np.abs(place - 0.5) <= 0.5 * duty, 1.0, 0.0)


def unplanned_lobes(request: SequenceRequest, frequency_hz: float, tx_s: float) -> Lobes:
    """Half periods of a constant frequency or of a linear chirp from `frequency_hz` to `frequency_hz` + chirp_hz.

    A half period that would extend beyond TX is omitted, so that the field ends at a zero.
    """
    slope = request.chirp_hz / tx_s
    turn = request.phase_rad / np.pi  # half periods before TX
    first = math.floor(turn + ALMOST)
    # Zeros where 2 (f t + slope t^2 / 2) + turn is whole; before TX the frequency is constant.
    last = math.floor(2 * (frequency_hz * tx_s + 0.5 * slope * tx_s**2) + turn + ALMOST)
    half = np.arange(first, last + 1) - turn
    root = np.sqrt(np.maximum(frequency_hz**2 + slope * np.maximum(half, 0.0), 0.0))
    zeros = np.where(half <= 0, half / (2 * frequency_hz), half / (frequency_hz + root))
    return Lobes(zeros, 1 if first % 2 == 0 else -1, request.waveform, request.duty)

"""What a card's filters and converters make of the volts at its inputs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .options import AXES, BoardOptions

HALF = 32768


def filter_delay(decimation: int, *, fir: bool) -> float:
    """How many samples a signal appears late in the recording."""
    cic = ((decimation / 2 if fir else decimation) - 1) / 2 * 6 / decimation
    return cic + (92 - 1) / 2 / 2 if fir else cic


def adc_gain(decimation: int, *, fir: bool) -> float:
    """Gain of the first decimation filter, which nothing takes off; 1 for powers of two."""
    rate = decimation / 2 if fir else decimation
    return float(rate**6 / 2 ** math.ceil(6 * math.log2(rate)))


def adc_codes(volts: NDArray[np.float32], options: BoardOptions, gain: float) -> NDArray[np.float64]:
    """(n, 2) codes of the volts (3, n) of the three axes; 0 at an input that nothing is connected to."""
    codes = np.zeros((volts.shape[1], 2))
    for column, axis in enumerate(options.inputs):
        if axis:
            u = volts[AXES.index(axis)].astype(np.float64)
            u = (u - options.adc_offset_v[column]) / options.adc_scale_v[column]
            codes[:, column] = np.rint(np.clip(u, -HALF, HALF - 1) * gain)
    return codes

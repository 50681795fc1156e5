"""The calibration of a platform: receive sensitivity with its frequency response, and the transmit side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ReceiveCalibration:
    """Receive side, paper eq:u(t,p,R): u = -P dm/dt.

    sensitivity: (channel, 3) float64, V/(A m^2/s) = T/A, columns world x, y, z, all gains up to the ADC input included
    (at the LNA gain `lna_gain`, V/V); frequency_hz: (k,) and frequency_response: (channel, k) complex, multiplies the
    sensitivity, None: flat; identifier and date (ISO 8601) name this calibration in every recording made with it.
    """

    sensitivity: NDArray[np.float64]
    identifier: str
    date: str
    lna_gain: float | None = None
    frequency_hz: NDArray[np.float64] | None = None
    frequency_response: NDArray[np.complex128] | None = None


@dataclass(frozen=True)
class TransmitChannel:
    """Transmit side of one coil axis: from the DAC output to the field at the rotor.

    output: index of the DAC output; amplifier_gain: V/V; resistance_ohm and inductance_h: of the whole loop, amplifier
    output impedance included; field_per_ampere_t: (3,) T/A at the rotor's position in world axes.
    """

    axis: str
    output: int
    amplifier_gain: float
    amplifier_limit_v: float
    resistance_ohm: float
    inductance_h: float
    field_per_ampere_t: NDArray[np.float64]

    def impedance_ohm(self, frequency_hz: float) -> complex:
        """Complex loop impedance at a frequency."""
        return complex(self.resistance_ohm, 2 * np.pi * frequency_hz * self.inductance_h)

"""The calibration that belongs to the simulated platform: exact, unless its table contains errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration, TransmitChannel
from sim_backend.options import CalibrationTable, SimulatedOptions
from sim_backend.transmit.coils import AXES, pair_field_t, sensitivity_t_per_a

from .response import frequency_response, is_flat

FINE_HZ, COARSE_HZ, FINE_UP_TO_HZ = 10.0, 50.0, 3000.0


def receive_calibration(
    options: SimulatedOptions, table: CalibrationTable, position_m: NDArray[np.float64]
) -> ReceiveCalibration:
    """Sensitivity at a position (3,), m, and response of the receive chain in use, at the LNA gain of the table."""
    sensitivity = sensitivity_t_per_a(options.coils, position_m) * table.lna_gain
    sensitivity *= 1 + np.array(table.gain_error)[:, None]
    chain = options.receive.in_place()
    flat = is_flat(chain)
    frequency_hz = calibration_frequencies_hz(table.frequency_max_hz)
    return ReceiveCalibration(
        sensitivity=sensitivity,
        identifier=table.identifier,
        date=table.date,
        lna_gain=table.lna_gain,
        frequency_hz=None if flat else frequency_hz,
        frequency_response=None if flat else frequency_response(chain, frequency_hz),
    )


def calibration_frequencies_hz(highest_hz: float) -> NDArray[np.float64]:
    """Frequencies of the tabulated response, (k,), Hz.

    They are so close that linear interpolation of a 20 kHz pole has an error of about 1e-7 where the rotor has its
    lines.
    """
    fine = np.arange(0.0, min(FINE_UP_TO_HZ, highest_hz), FINE_HZ)
    coarse = np.arange(FINE_UP_TO_HZ, highest_hz + COARSE_HZ, COARSE_HZ)
    return np.concatenate([fine, coarse])


def transmit_channels(options: SimulatedOptions, position_m: NDArray[np.float64]) -> tuple[TransmitChannel, ...]:
    """The coils x, y, z as seen from the DAC, exact; fields at position_m (3,), m."""
    amplifier = options.amplifier
    return tuple(
        TransmitChannel(
            axis=axis,
            output=k,
            amplifier_gain=amplifier.gain,
            amplifier_limit_v=amplifier.limit_v,
            resistance_ohm=coil.resistance_ohm + amplifier.output_impedance_ohm,
            inductance_h=coil.inductance_h,
            field_per_ampere_t=pair_field_t(coil, k, position_m),
        )
        for k, (axis, coil) in enumerate(zip(AXES, options.coils.in_order(), strict=True))
    )

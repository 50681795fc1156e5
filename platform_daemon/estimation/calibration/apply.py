"""From volts to dm/dt: the inverse of u = -P dm/dt (eq:u(t,p,R)), corrected for the receive chain's response."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.sensitivity import CalibrationError, inverse_sensitivity, real_array

from .equaliser import design_equaliser, equalise


@dataclass(frozen=True, kw_only=True)
class CalibratedRecord:
    """Calibrated signal.

    Attributes:
        dmdt: (3, n) A m^2/s in world axes; sample 0 is still the first RX sample.
        valid_from, valid_to: half-open range of samples that no filter edge has touched.
        notes: what had to be assumed.
    """

    dmdt: Array
    valid_from: int
    valid_to: int
    notes: tuple[str, ...] = ()


def calibrate(
    volts: Array,
    sampling_rate_hz: float,
    sensitivity: Array,
    frequency_hz: Array | None = None,
    frequency_response: ComplexArray | None = None,
) -> CalibratedRecord:
    """dm/dt = -P^+ H^-1 u.

    Args:
        volts: (channels, n) V at the ADC input, RX part only.
        sampling_rate_hz: samples per second.
        sensitivity: P, (channels, 3), T/A; more than three channels: least squares.
        frequency_hz: (k,) grid of the response, or None for a flat chain.
        frequency_response: H, complex (channels, k), multiplies P.

    Raises:
        CalibrationError: complex values, wrong shape, NaN, singular P, or a response that cannot be inverted.
    """
    volts = real_array(volts, "volts")
    if volts.ndim != 2 or volts.shape[1] == 0:
        raise CalibrationError(f"volts must have shape (channels, n), not {volts.shape}")
    inverse = inverse_sensitivity(sensitivity, volts.shape[0])
    n = volts.shape[1]
    if frequency_hz is None and frequency_response is None:
        return CalibratedRecord(dmdt=-inverse @ volts, valid_from=0, valid_to=n)
    grid, response = _checked_response(frequency_hz, frequency_response, volts.shape[0])
    equaliser = design_equaliser(grid, response, sampling_rate_hz)
    reach = equaliser.reach
    if n <= 2 * reach:
        raise CalibrationError(f"the record of {n} samples is shorter than the equaliser's {2 * reach + 1} taps")
    flat = equalise(volts, equaliser)
    return CalibratedRecord(dmdt=-inverse @ flat, valid_from=reach, valid_to=n - reach, notes=equaliser.notes)


def _checked_response(
    frequency_hz: Array | None, response: ComplexArray | None, channels: int
) -> tuple[Array, ComplexArray]:
    """Grid (k,) and response (channels, k), sound enough to be inverted."""
    if frequency_hz is None or response is None:
        raise CalibrationError("a frequency response needs both its frequencies and its values")
    grid = real_array(frequency_hz, "frequency")
    values = np.asarray(response, dtype=np.complex128)
    if grid.ndim != 1 or grid.size < 2 or np.any(np.diff(grid) <= 0.0) or grid[0] < 0.0:
        raise CalibrationError("frequency must hold at least two rising values >= 0 Hz")
    if values.shape != (channels, grid.size):
        raise CalibrationError(f"frequency_response must have shape ({channels}, {grid.size}), not {values.shape}")
    if not (np.all(np.isfinite(grid)) and np.all(np.isfinite(values))):
        raise CalibrationError("frequency response contains NaN or infinity")
    if np.any(values == 0.0):
        raise CalibrationError("frequency_response is zero somewhere and cannot be inverted")
    return grid, values

"""The transmit side from the answers of a field probe: field per volt at the DAC, per coil and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from drivers.calibration import TransmitChannel
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.calibration


@dataclass(frozen=True)
class TransmitResult:
    """What a calibration of the transmit side found.

    frequency_hz: (k,); field_per_volt: (coil, 3, k) complex, T/V at the DAC; std: the same shape, of the real and of
    the imaginary part, from noise; relative_std: of the probe; field_per_ampere_t: (coil, 3) and inductance_h: (coil,)
    of the loop that explains it with the declared amplifier gain and resistance; chi2_per_dof: of that explanation.
    """

    frequency_hz: NDArray[np.float64]
    field_per_volt: NDArray[np.complex128]
    std: NDArray[np.float64]
    relative_std: float
    field_per_ampere_t: NDArray[np.float64]
    inductance_h: NDArray[np.float64]
    chi2_per_dof: NDArray[np.float64]


def transmit_result(
    frequency_hz: NDArray[np.float64],
    field_per_volt: NDArray[np.complex128],
    std: NDArray[np.float64],
    relative_std: float,
    channels: Sequence[TransmitChannel],
) -> TransmitResult:
    """Explain each coil's field per volt as gain * b / (R + i omega L), b and L free.

    Gain and R cannot be separated from b by a field alone, so the declared ones are kept: the currents that the limits
    are checked against are as good as they are.
    """
    loops = [_loop(frequency_hz, v, s, c) for v, s, c in zip(field_per_volt, std, channels, strict=True)]
    return TransmitResult(
        frequency_hz=frequency_hz,
        field_per_volt=field_per_volt,
        std=std,
        relative_std=relative_std,
        field_per_ampere_t=np.array([b for b, _, _ in loops]),
        inductance_h=np.array([henry for _, henry, _ in loops]),
        chi2_per_dof=np.array([chi2 for _, _, chi2 in loops]),
    )


def _loop(
    frequency_hz: NDArray[np.float64],
    field_per_volt: NDArray[np.complex128],
    std: NDArray[np.float64],
    channel: TransmitChannel,
) -> tuple[NDArray[np.float64], float, float]:
    """Field per ampere (3,), inductance and chi2 per degree of freedom of one coil."""
    omega = 2 * np.pi * frequency_hz

    def per_ampere(henry: float) -> NDArray[np.complex128]:
        return np.asarray(channel.amplifier_gain / (channel.resistance_ohm + 1j * omega * henry))

    def best_field(henry: float) -> NDArray[np.float64]:
        shape, weight = per_ampere(henry), 1 / std**2
        top = np.sum(weight * (np.conj(shape) * field_per_volt).real, axis=1)
        return np.asarray(top / np.sum(weight * np.abs(shape) ** 2, axis=1))

    def left(x: NDArray[np.float64]) -> NDArray[np.float64]:
        henry = channel.inductance_h * float(x[0])
        off = ((field_per_volt - best_field(henry)[:, None] * per_ampere(henry)) / std).ravel()
        return np.concatenate([off.real, off.imag])

    found = least_squares(left, x0=[1.0], x_scale=[LIMITS.coil_scale])
    henry = channel.inductance_h * float(found.x[0])
    dof = max(1, 6 * frequency_hz.size - 4)
    return best_field(henry), henry, float(2 * found.cost / dof)

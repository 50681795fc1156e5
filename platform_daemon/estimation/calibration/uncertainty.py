"""What the uncertainty of P does to a fitted m_r.

An error of P scales the fundamental, v ~ m_r A for the amplitude A of the motion, by 1 + e_v and the second harmonic,
u ~ m_r A^2, by 1 + e_u (eq:projection).  Where only u/v determines the amplitude, m_r ~ v^2/u moves by 2 e_v - e_u;
what else determines it (how the frequency follows the amplitude, large swings) makes that less.  The worst case is
taken.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.result import FitResult

MOMENT = "m_r_am2"
C_V, C_U = 2.0, -1.0  # how m_r follows the errors of v and u, at most


def systematic_std(calibration: ReceiveCalibration | None, fit: FitResult) -> dict[str, float]:
    """Standard uncertainty of m_r, A m^2, from that of P at f_nat and 2 f_nat; {} if the calibration does not say.

    What all of P has in common scales m_r; the noise of its elements at both frequencies is independent.
    """
    if calibration is None or MOMENT not in fit.parameters or fit.is_fixed(MOMENT):
        return {}
    common = _common(calibration)
    if common is None:
        return {}
    by_noise = 0.0
    if calibration.p_std is not None:
        e_v, e_u = _error_of_harmonics(calibration, fit)
        by_noise = math.hypot(C_V * e_v, C_U * e_u)
    return {MOMENT: fit.parameters[MOMENT].value * math.hypot(common, by_noise)}


def _common(calibration: ReceiveCalibration) -> float | None:
    """Relative standard deviation that all of P shares; where only the sensitivity's is given, the largest of it."""
    if calibration.relative_std is not None or calibration.sensitivity_std is None:
        return calibration.relative_std
    size = np.abs(calibration.sensitivity)
    strongest = np.argmax(size, axis=1)[:, None]
    ratio = np.take_along_axis(calibration.sensitivity_std, strongest, 1) / np.take_along_axis(size, strongest, 1)
    return float(ratio.max())


def _error_of_harmonics(calibration: ReceiveCalibration, fit: FitResult) -> tuple[float, float]:
    """Relative standard deviation of the fundamental, along e_v, and of the second harmonic, along e_u."""
    e_u, e_v, _ = rotation_from_rodrigues(np.array([fit.parameters[n].value for n in RODRIGUES])).T
    f_nat = fit.parameters["f_nat_hz"].value
    return _error_along(calibration, e_v, f_nat), _error_along(calibration, e_u, 2 * f_nat)


def _error_along(calibration: ReceiveCalibration, axis: NDArray[np.float64], hz: float) -> float:
    """Of the signal of a dipole along a world axis (3,) at a frequency, seen along that axis."""
    assert calibration.p_std is not None
    assert calibration.frequency_hz is not None
    assert calibration.frequency_response is not None
    k = int(np.argmin(np.abs(calibration.frequency_hz - hz)))
    std = calibration.p_std[:, :, k] / np.abs(calibration.frequency_response[:, k])[:, None]
    weights = axis @ np.linalg.pinv(calibration.sensitivity)
    return float(np.linalg.norm(weights[:, None] * std * axis))

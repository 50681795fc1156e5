"""What the harmonics of one shot tell, at constant cost: for live display and as a cross-check of the fit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from platform_daemon.estimation import RefusedError, estimate_from_harmonics
from platform_daemon.store import Recording

from .calibrated import checked_clipping, ring_down

_MOST_SAMPLES = 2**16  # 1 s at 61 kHz: more than the estimator looks at, and the calibration then costs always the same


def frame_harmonics(recording: Recording, k: int) -> dict[str, Any]:
    """The report of a stored frame; refused where the daemon refused the frame, or did not excite it.

    Raises InputError for a frame that does not exist, RecordingError for one that cannot be read.
    """
    volts = recording.rx_volts(k)
    info = recording.frame_info[k]
    if info.verdict != "good" or info.blank:
        return _refused("a blank shot, without excitation" if info.blank else info.reason)
    return harmonics_report(volts, recording.sequence.rate_hz, recording.calibration)


def harmonics_report(
    rx_volts: NDArray[np.float64], rate_hz: float, calibration: ReceiveCalibration | None
) -> dict[str, Any]:
    """Frequency, amplitude, moment, orientation and decay in the first periods of (c, n) V, or why there are none.

    SI units; no errors are given: the bias against the fit stands in estimation/harmonic_estimator/estimator.py.
    Raises RecordingError if the calibration does not fit the data.
    """
    volts = rx_volts[:, :_MOST_SAMPLES]
    record, _ = ring_down(volts, rate_hz, calibration)
    try:
        checked_clipping(volts)
        found = estimate_from_harmonics(record)
    except (RefusedError, ValueError) as refused:
        return _refused(str(refused))
    return {
        "verdict": "good",
        "reason": None,
        "time_s": found.time_s,
        "stretch_s": found.stretch_s,
        "frequency_hz": found.frequency_hz,
        "chirp_hz_per_s": found.chirp_hz_per_s,
        "f_nat_hz": found.f_nat_hz,
        "m_r_am2": found.m_r_am2,
        "amplitude_rad": found.amplitude_rad,
        "amplitude_at_start_rad": found.amplitude_at_start_rad,
        "decay_per_s": found.decay_per_s,
        "lambda_per_s": found.lambda_per_s,
        "rodrigues_rad": found.rodrigues.tolist(),
        "harmonics_am2_per_s": found.harmonics.tolist(),
        "second_harmonic_snr": found.second_harmonic_snr,
    }


def _refused(reason: str) -> dict[str, Any]:
    return {"verdict": "refused", "reason": reason}

"""What the harmonics of one shot tell, at constant cost: for live display and as a cross-check of the fit."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from platform_daemon.core.schemas.fits import BLANK
from platform_daemon.core.schemas.harmonics import HarmonicEstimate, RefusedHarmonicEstimate
from platform_daemon.estimation.harmonic_estimator.estimator import estimate_from_harmonics
from platform_daemon.estimation.refusal import RefusedError

from .calibrated import calibrated_signal
from .measurement import VoltageMeasurement

_MOST_SAMPLES = 2**16  # 1 s at 61 kHz: more than the estimator looks at, and the calibration then costs always the same
Harmonics = HarmonicEstimate | RefusedHarmonicEstimate


def frame_harmonics(measurement: VoltageMeasurement, k: int) -> Harmonics:
    """Of a stored frame, with its number; refused where the daemon refused the frame, blank where it did not excite it.

    Raises InputError for a frame that does not exist, RecordingError for one that cannot be read.
    """
    recording = measurement.recording
    volts, excuse = recording.rx_volts(k), measurement.excuse(k)
    if excuse is not None:
        verdict: Literal["refused", "blank"] = "blank" if excuse == BLANK else "refused"
        return RefusedHarmonicEstimate(frame=k, verdict=verdict, reason=excuse)
    found = shot_harmonics(volts, recording.sequence.rate_hz, recording.calibration)
    return found.model_copy(update={"frame": k})


def shot_harmonics(rx_volts: NDArray[np.float64], rate_hz: float, calibration: ReceiveCalibration | None) -> Harmonics:
    """Frequency, amplitude, moment, orientation and decay in the first periods of (c, n) V, or why there are none.

    No errors are given: the bias against the fit is documented in estimation/harmonic_estimator.
    Raises RecordingError if the calibration does not fit the data.
    """
    signal = calibrated_signal(rx_volts[:, :_MOST_SAMPLES], rate_hz, calibration)
    try:
        signal.harmless_clipping()
        found = estimate_from_harmonics(signal.record)
    except (RefusedError, ValueError) as refused:
        return RefusedHarmonicEstimate(verdict="refused", reason=str(refused))
    return HarmonicEstimate(
        verdict="good",
        reason=None,
        time_s=found.time_s,
        stretch_s=found.stretch_s,
        frequency_hz=found.frequency_hz,
        chirp_hz_per_s=found.chirp_hz_per_s,
        f_nat_hz=found.f_nat_hz,
        m_r_am2=found.m_r_am2,
        amplitude_rad=found.amplitude_rad,
        amplitude_at_start_rad=found.amplitude_at_start_rad,
        decay_per_s=found.decay_per_s,
        lambda_per_s=found.lambda_per_s,
        rodrigues_rad=tuple(found.rodrigues.tolist()),
        harmonics_am2_per_s=tuple(found.harmonics.tolist()),
        second_harmonic_snr=found.second_harmonic_snr,
    )

"""The noise of a recording: one model for all its frames, found once."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import PlatformError
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.screening.clipping import saturation
from platform_daemon.estimation.screening.oscillation import find_oscillation

from .calibrated import calibrated_signal

_FRAMES = 12  # as many as a series learns from
_LOOK_S = 1.0


def recording_noise(recording: Recording) -> SeriesNoise:
    """Noise of a recording's frames, of the blank ones if it has any; independent of the caller and the next frame.

    Kept per process while the file and its calibration stay what they are.
    """
    return _found(_CacheKey(recording))


class _CacheKey:
    """Key of the cache of noises: a recording, equal to others of the same file and calibration."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        used = recording.calibration
        arrays = () if used is None else (used.sensitivity, used.frequency_hz, used.frequency_response)
        content = tuple(None if a is None else np.asarray(a).tobytes() for a in arrays)
        undone = () if used is None else used.receiver
        self._key = (*recording.content_key, content, undone)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _CacheKey) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


@lru_cache(4)
def _found(key: _CacheKey) -> SeriesNoise:
    return noise_of_frames(key.recording, _frames_to_learn_from(key.recording))


def noise_of_frames(recording: Recording, frames: Sequence[int]) -> SeriesNoise:
    """What these frames tell of the noise."""
    noise = SeriesNoise()
    rings_hz = _rings_hz(recording) if any(recording.frame_info[k].blank for k in frames) else None
    for k in frames:
        rate_hz, blank = recording.sequence.rate_hz, recording.frame_info[k].blank
        # A frame that cannot be read or calibrated says so when it is fitted.
        with suppress(PlatformError):
            volts = recording.rx_volts(k)
            learn_noise(noise, volts, rate_hz, recording.calibration, blank=blank, rings_hz=rings_hz)
    return noise


def _rings_hz(recording: Recording) -> float | None:
    """Where the rotor swings in the last good shot, Hz; None if it cannot be seen."""
    excited = [k for k, info in enumerate(recording.frame_info) if info.verdict == "good" and not info.blank]
    with suppress(PlatformError):
        if excited:
            rate_hz = recording.sequence.rate_hz
            volts = recording.rx_volts(excited[-1])[:, : int(_LOOK_S * rate_hz)]
            line = find_oscillation(calibrated_signal(volts, rate_hz, recording.calibration).record)
            return None if line is None else line.frequency_hz
    return None


def learn_noise(
    noise: SeriesNoise,
    rx_volts: NDArray[np.float64],
    rate_hz: float,
    calibration: ReceiveCalibration | None,
    *,
    blank: bool,
    rings_hz: float | None = None,
) -> None:
    """Let a series' noise learn from one RX window, (c, n) V, unless it is clipped.  Raises RecordingError."""
    if saturation(rx_volts) is None:
        noise.learn(calibrated_signal(rx_volts, rate_hz, calibration).record, blank=blank, rings_hz=rings_hz)


def _frames_to_learn_from(recording: Recording) -> list[int]:
    """Blank frames, else some that are spread over the series."""
    good = [k for k, info in enumerate(recording.frame_info) if info.verdict == "good"]
    blank = [k for k in good if recording.frame_info[k].blank]
    chosen = blank or good
    places = np.linspace(0, len(chosen) - 1, min(_FRAMES, len(chosen))).round().astype(int)
    return [chosen[p] for p in places]

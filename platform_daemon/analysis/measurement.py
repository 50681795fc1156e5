"""One way to open what was measured: coil voltages and angles look the same to every analysis."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError, RecordingError
from platform_daemon.estimation import Conditions, RingDownRecord, SeriesNoise
from platform_daemon.schemas import BLANK
from platform_daemon.store import AngleSeries, Recording, is_time_series, open_recording, read_angles

from .calibrated import FrameSignal, calibrated_signal
from .fit_request import NAME_THE_VARIANT, FitRequest, FitSettings, check_fixed, checked_variant
from .frames import chosen_frames
from .known_moment import known_moment_am2
from .model_registry.adopted_model import AdoptedModel
from .model_registry.resolve import ModelChoice, with_receiver_correction
from .noise import recording_noise

PENDULUM = "thread"  # of which an angle is taken unless a variant is named
UNCALIBRATED = "no calibration: only voltage-domain quantities can be estimated (f_nat, lambda, T_f/I, phi_max, psi)"
Calibration = tuple[ReceiveCalibration, str]
"""One in the place of a file's own, and where it came from."""


@dataclass(frozen=True, eq=False)
class Measurement(ABC):
    """Frames of one file, whatever was measured.

    Attributes:
        path: of the file; frames: how many it holds.
        variant: what the file says that it holds; None: it does not say.
        calibration: that its signals are made with; None: they are volts, or an angle, which needs none.
        notes: what holds for all frames.
    """

    path: Path
    frames: int
    variant: str | None
    calibration: ReceiveCalibration | None
    notes: tuple[str, ...]

    def under(self, model: ModelChoice | None, terms: Sequence[str] = ()) -> tuple[Measurement, ModelChoice]:
        """The caller's model, else the file's, with further torque terms; and the measurement as that model wants it.

        Raises InputError if there is none, or if it cannot be used here.
        """
        if isinstance(model, AdoptedModel):
            if terms:
                remedy = "diagnose on the base of it and adopt what is found, or leave the terms out"
                raise InputError("an adopted model takes no further terms", where=model.label, remedy=remedy)
            return self._corrected(model), model
        chosen = model or self.variant
        if chosen is None:
            where = f"{self.path}: /resonator/variant"
            raise RecordingError("the file does not say which resonator it holds", where=where, remedy=NAME_THE_VARIANT)
        return self, checked_variant(chosen, terms)

    def excuse(self, k: int) -> str | None:
        """Why frame `k` is not to be fitted, though it may be read; None: it is to be fitted."""
        return None

    def noise(self) -> SeriesNoise:
        """Of the series; one that knows nothing leaves it to each fit to find its own."""
        return SeriesNoise()

    def conditions(self, k: int) -> Conditions:
        """Under which frame `k` was taken."""
        return Conditions()

    def moment_am2(self) -> float | None:
        """What is known of the moment of the resonator that the file names, A m^2."""
        return None

    @abstractmethod
    def signal(self, k: int) -> FrameSignal:
        """Frame `k`.  Raises InputError if it does not exist, RecordingError if it cannot be read or calibrated."""

    @abstractmethod
    def times_s(self) -> list[float | None]:
        """When each frame was taken, s from any zero; None where the file does not say."""

    @abstractmethod
    def _corrected(self, model: AdoptedModel) -> Measurement:
        """With the receiver effects of the model undone.  Raises RecordingError where they cannot be."""


@dataclass(frozen=True, eq=False)
class VoltageMeasurement(Measurement):
    """A recording of coil voltages."""

    recording: Recording

    @classmethod
    def of(cls, recording: Recording) -> VoltageMeasurement:
        """An open recording."""
        used = recording.calibration
        notes = (UNCALIBRATED,) if used is None else ()
        return cls(recording.path, recording.frames, recording.variant, used, notes, recording)

    def excuse(self, k: int) -> str | None:
        """See Measurement."""
        info = self.recording.frame_info[k]
        return BLANK if info.blank else info.reason if info.verdict != "good" else None

    def noise(self) -> SeriesNoise:
        """See Measurement."""
        return recording_noise(self.recording)

    def conditions(self, k: int) -> Conditions:
        """See Measurement."""
        return Conditions(self.recording.frame_info[k].temperature_c, self.recording.lna_gain)

    def moment_am2(self) -> float | None:
        """See Measurement."""
        return known_moment_am2(self.recording)

    def signal(self, k: int) -> FrameSignal:
        """See Measurement."""
        return calibrated_signal(self.recording.rx_volts(k), self.recording.sequence.rate_hz, self.calibration)

    def times_s(self) -> list[float | None]:
        """By the host's monotonic clock, else by the time stamps."""
        monotonic = [info.monotonic_s for info in self.recording.frame_info]
        if all(t is not None and math.isfinite(t) for t in monotonic):
            return monotonic
        return [_stamp(info.time_stamp) for info in self.recording.frame_info]

    def _corrected(self, model: AdoptedModel) -> Measurement:
        return VoltageMeasurement.of(with_receiver_correction(self.recording, model))


@dataclass(frozen=True, eq=False)
class AngleMeasurement(Measurement):
    """An angle over time: one frame, with the angle's parameters."""

    series: AngleSeries

    def signal(self, k: int) -> FrameSignal:
        """See Measurement."""
        chosen_frames(self, (k,))
        record = RingDownRecord(self.series.angle_rad, self.series.sampling_rate_hz, "angle")
        return FrameSignal(record, None, self.series.clock)

    def times_s(self) -> list[float | None]:
        """Of the one frame."""
        return [0.0]

    def _corrected(self, model: AdoptedModel) -> Measurement:
        if model.receiver:
            why = "it undoes effects of a receiver, which an angle has not"
            remedy = "use a model of torques alone"
            raise RecordingError(f"{model.label} cannot be used here", where=str(self.path), why=why, remedy=remedy)
        return self


def open_measurement(path: Path, calibration: Calibration | None = None) -> Measurement:
    """A recording under this calibration or its own, or an angle.

    Raises RecordingError if it cannot be read, or if the calibration does not fit or applies to nothing here.
    """
    if not is_time_series(path):
        return open_voltages(path, calibration)
    if calibration is not None:
        remedy = "leave --calibration out for this file"
        raise RecordingError("holds an angle, which no calibration applies to", where=str(path), remedy=remedy)
    return AngleMeasurement(path, 1, PENDULUM, None, (), read_angles(path))


def open_voltages(path: Path, calibration: Calibration | None = None) -> VoltageMeasurement:
    """A recording under this calibration or its own.  Raises RecordingError, for an angle too."""
    recording = open_recording(path)
    return VoltageMeasurement.of(recording if calibration is None else recording.with_calibration(*calibration))


def open_for_fit(path: Path, settings: FitSettings) -> tuple[Measurement, FitRequest]:
    """A file as the settings want it, and what to ask of it.

    Raises InputError for a model that cannot be used or a parameter that cannot be held, and what opening raises.
    """
    measurement, model = open_measurement(path, settings.calibration).under(settings.model, settings.terms)
    ask = FitRequest(model, settings.window, settings.fixed, settings.hold_if_inseparable, measurement.moment_am2())
    check_fixed(ask, calibrated=measurement.calibration is not None)
    return measurement, ask


def _stamp(text: str | None) -> float | None:
    try:
        return None if not text else datetime.fromisoformat(text).timestamp()
    except ValueError:
        return None

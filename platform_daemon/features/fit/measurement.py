"""One way to open what was measured: coil voltages and angles look the same to every analysis."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.angle_series import AngleSeries, is_time_series, read_angles
from platform_daemon.core.recordings.column_file import is_column_file, read_columns
from platform_daemon.core.recordings.procedure_steps import chosen_step
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.recordings.value_sources import sources_of_frames
from platform_daemon.core.schemas.fits import BLANK
from platform_daemon.core.schemas.value_sources import Origin, ValueSource
from platform_daemon.estimation.calibration.validity import ShotConditions
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.result import FitResult
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.resolve import ModelChoice, with_receiver_correction, with_terms

from .calibrated import FrameSignal, calibrated_signal
from .drive_hint import with_drive_hint
from .fit_request import NAME_THE_VARIANT, FitRequest, FitSettings, check_fixed
from .frames import chosen_frames
from .known_moment import known_moment_am2
from .known_weight import recorded_weight_over_pull
from .noise import recording_noise

PENDULUM = "thread"  # of which an angle is taken unless a variant is named
SPRING = "thread_small_angle"  # the same with a linear restoring torque
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
        chosen = model or self.variant
        if chosen is None:
            where = f"{self.path}: /resonator/variant"
            raise RecordingError("the file does not say which resonator it holds", where=where, remedy=NAME_THE_VARIANT)
        used = with_terms(chosen, terms)
        return (self._corrected(used) if isinstance(used, AdoptedModel) else self), used

    def excuse(self, k: int) -> str | None:
        """Why frame `k` is not to be fitted, though it may be read; None: it is to be fitted."""
        return None

    def noise(self) -> SeriesNoise:
        """Of the series; one that knows nothing leaves it to each fit to find its own."""
        return SeriesNoise()

    def conditions(self, k: int) -> ShotConditions:
        """Under which frame `k` was taken."""
        return ShotConditions()

    @property
    def other_layout(self) -> str:
        """What a reader must know of a file whose layout this version does not know; "": it knows it."""
        return ""

    def moment_am2(self) -> float | None:
        """What is known of the moment of the resonator that the file names, A m^2."""
        return None

    def weight_over_pull(self) -> float:
        """Of the rotor of the resonator that the file names, see `known_weight`; 0: it is not known."""
        return 0.0

    def value_sources(self, frames: Iterable[int]) -> tuple[ValueSource, ...]:
        """Where the values come from that these frames were made with, and the calibration; (): nothing is known."""
        return ()

    def with_hint(self, k: int, fit: FitResult) -> FitResult:
        """The fit of frame `k`, whose refusal for want of a signal names the cause that the file knows."""
        return fit

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
    calibration_file: str | None = None
    """File of a calibration in the place of the recording's own; None: it is the recording's own."""
    known_noise: SeriesNoise | None = None
    """Of the series, if it is known from elsewhere; None: the frames tell it."""

    @classmethod
    def of(
        cls, recording: Recording, calibration_file: str | None = None, known_noise: SeriesNoise | None = None
    ) -> VoltageMeasurement:
        """An open recording."""
        used = recording.calibration
        notes = tuple(note for note in (UNCALIBRATED if used is None else "", recording.other_layout) if note)
        return cls(
            recording.path, recording.frames, recording.variant, used, notes, recording, calibration_file, known_noise
        )

    def excuse(self, k: int) -> str | None:
        """See Measurement."""
        info = self.recording.frame_info[k]
        return BLANK if info.blank else info.reason if info.verdict != "good" else None

    def noise(self) -> SeriesNoise:
        """See Measurement."""
        return self.known_noise or recording_noise(self.recording)

    def conditions(self, k: int) -> ShotConditions:
        """See Measurement."""
        return ShotConditions(self.recording.frame_info[k].temperature_c, self.recording.lna_gain)

    @property
    def other_layout(self) -> str:
        """See Measurement."""
        return self.recording.other_layout

    def moment_am2(self) -> float | None:
        """See Measurement."""
        return known_moment_am2(self.recording)

    def weight_over_pull(self) -> float:
        """See Measurement."""
        return recorded_weight_over_pull(self.recording)

    def with_hint(self, k: int, fit: FitResult) -> FitResult:
        """See Measurement."""
        return with_drive_hint(fit, self.recording, k)

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
        corrected = with_receiver_correction(self.recording, model)
        return VoltageMeasurement.of(corrected, self.calibration_file, self.known_noise)

    def value_sources(self, frames: Iterable[int]) -> tuple[ValueSource, ...]:
        """See Measurement."""
        of_series = sources_of_frames(self.recording, frames)
        if self.calibration is None:
            return of_series
        own = self.calibration_file is None
        origin = Origin("recording") if own else Origin("file", path=self.calibration_file)
        return (*of_series, origin.of("calibration", self.calibration.identifier or "without a name"))


@dataclass(frozen=True, eq=False)
class AngleMeasurement(Measurement):
    """An angle over time: one frame, with the angle's parameters."""

    series: AngleSeries

    def signal(self, k: int) -> FrameSignal:
        """See Measurement."""
        chosen_frames(self, (k,))
        record = RingDownRecord(self.series.angle_rad, self.series.sampling_rate_hz, "angle")
        return FrameSignal(record, None, (*self.series.clock, *self.series.done))

    def with_hint(self, k: int, fit: FitResult) -> FitResult:
        """See Measurement: a swing of a few degrees that is read as rad goes far round, and fits no motion."""
        reached = float(np.nanmax(np.abs(self.series.angle_rad)))
        if fit.reason is None or reached < math.pi / 2:
            return fit
        hint = f"it reaches {reached:.4g} rad, beyond 90 deg: if these are degrees, convert them, or say unit = 'deg'"
        return replace(fit, reason=f"{fit.reason}; {hint}")

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
    if is_column_file(path):
        return measurement_of(read_columns(path), calibration)
    if not is_time_series(path):
        return open_voltages(path, calibration)
    return measurement_of(read_angles(path), calibration)


def measurement_of(
    signal: Recording | AngleSeries, calibration: Calibration | None = None, noise: SeriesNoise | None = None
) -> Measurement:
    """What was measured, as analyses take it; noise: if it is known from elsewhere.

    Raises RecordingError if the calibration does not fit, or applies to nothing here.
    """
    if isinstance(signal, Recording):
        if calibration is None:
            return VoltageMeasurement.of(signal, known_noise=noise)
        return VoltageMeasurement.of(signal.with_calibration(*calibration), calibration[1], noise)
    if calibration is not None:
        remedy = "leave --calibration out for this file"
        raise RecordingError("holds an angle, which no calibration applies to", where=str(signal.path), remedy=remedy)
    return AngleMeasurement(signal.path, 1, PENDULUM, None, (), signal)


def open_voltages(path: Path, calibration: Calibration | None = None) -> VoltageMeasurement:
    """A recording under this calibration or its own.  Raises RecordingError, for an angle too."""
    found = read_columns(path) if is_column_file(path) else open_recording(path)
    if not isinstance(found, Recording):
        remedy = "this works on coil voltages or dm/dt; info, fit, plot, slide, budget and diagnose take angles"
        raise RecordingError("holds an angle, not coil voltages", where=str(path), remedy=remedy)
    if calibration is None:
        return VoltageMeasurement.of(found)
    return VoltageMeasurement.of(found.with_calibration(*calibration), calibration[1])


def open_for_fit(path: Path, settings: FitSettings) -> tuple[Measurement, FitRequest]:
    """A file as the settings want it, and what to ask of it.

    Raises InputError for a model that cannot be used or a parameter that cannot be held, and what opening raises.
    """
    opened = open_measurement(path, settings.calibration)
    _, said = taken_frames(opened, settings.frames, settings.step)
    measurement, model = replace(opened, notes=(*opened.notes, *said)).under(settings.model, settings.terms)
    held = settings.fixed, settings.hold_if_inseparable
    ask = FitRequest(model, settings.window, *held, measurement.moment_am2(), measurement.weight_over_pull())
    check_fixed(ask, calibrated=measurement.calibration is not None)
    return measurement, ask


def open_shots_for_fit(path: Path, settings: FitSettings) -> tuple[Measurement, FitRequest]:
    """As open_for_fit, of a recording: whoever asks needs its specimen and when its shots were made.

    Raises RecordingError for a table or an angle series, which say neither, and what open_for_fit raises.
    """
    if path.is_file():
        kind = "a table" if is_column_file(path) else "an angle series" if is_time_series(path) else None
        if kind is not None:
            what = f"is {kind}, which says neither of which specimen it is nor when its shots were made"
            remedy = "give a recording of this software; info, fit, plot, slide, budget and diagnose take this file"
            raise RecordingError(what, where=str(path), remedy=remedy)
    return open_for_fit(path, settings)


def taken_frames(
    measurement: Measurement, frames: Sequence[int] | None, step: str | None
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The frames that are meant, in order, and a note if they are those of one step of a procedure's recording.

    frames: those that are named, None: those of the step; step: see chosen_step.  Raises InputError for a frame or a
    step that does not exist, or if both are named.
    """
    if frames is not None:
        if step is not None:
            raise InputError("frames and a step exclude each other", where="step", remedy="name one of the two")
        return chosen_frames(measurement, frames), ()
    if not isinstance(measurement, VoltageMeasurement):
        if step is not None:
            raise InputError("an angle has no steps", where=str(measurement.path), remedy="leave the step out")
        return chosen_frames(measurement, None), ()
    found = chosen_step(measurement.recording, step)
    return (chosen_frames(measurement, None), ()) if found is None else (found[0].frames, (found[1],))


def _stamp(text: str | None) -> float | None:
    try:
        return None if not text else datetime.fromisoformat(text).timestamp()
    except ValueError:
        return None

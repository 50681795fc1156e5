"""On-line fits of a running series: each from the file of its shot, by whichever process computes.

What a series has learned of its noise, and its fits, travel as bytes: the process that owns the hardware keeps them and
never looks inside, so it needs none of what they are made of.
"""

from __future__ import annotations

import gc
import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.errors import RecordingError
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.base import Window
from platform_daemon.core.schemas.fits import CorrectionReport, FitReport, FrameFit, unfitted
from platform_daemon.core.schemas.harmonics import ShotHarmonics

if TYPE_CHECKING:
    from drivers.calibration import ReceiveCalibration
    from platform_daemon.core.recordings.recording import Recording
    from platform_daemon.estimation.noise.model import NoiseModel
    from platform_daemon.estimation.record import RingDownRecord
    from platform_daemon.estimation.result import FitResult
    from platform_daemon.features.models.resolve import ModelChoice

    from .fit_request import FitRequest


@dataclass(frozen=True)
class NamedModel:
    """A model by its label, for a process that must not load what it is made of.

    library: folder of adopted models; of_rotor: it holds a manufacturing error, so that fits are corrected for it.
    """

    label: str
    library: Path | None = None
    of_rotor: bool = False

    def choice(self) -> ModelChoice:
        """The model.  Raises InputError if it is not there any more."""
        from platform_daemon.features.models.library import Library
        from platform_daemon.features.models.resolve import resolve

        found = resolve(self.label, None if self.library is None else Library(self.library))
        assert found is not None
        return found


def checked_model(label: str, library: Path | None) -> NamedModel:
    """A declared or adopted model by the label that results are marked with; library: folder of adopted models.

    What the model is made of is not loaded.  Raises InputError, with the names that are known.
    """
    from platform_daemon.features.models.resolve import checked_variant, label_of

    found = NamedModel(label, library).choice()
    if isinstance(found, str):
        return NamedModel(checked_variant(found), library)
    return NamedModel(label_of(found), library, of_rotor=found.rotor is not None)


@dataclass(frozen=True)
class ShotFit:
    """Results of one shot.

    noise: what the series has learned, bytes for the next shot; harmonics: of an excited shot; frame: its fit as
    reported, with number 0, None: none was requested.
    """

    noise: bytes | None
    harmonics: ShotHarmonics | None
    frame: FrameFit | None = None


@dataclass(frozen=True)
class OnlineFit:
    """Reads a stored shot, learns from its noise and fits it.  A task of the task executor.

    file: recording of one shot; calibration: of the platform; window: None: no fit; blank: a shot without excitation;
    moment_am2: expected; noise: what was learned from the shots before, None: there were none.
    """

    file: Path
    calibration: ReceiveCalibration
    model: NamedModel
    window: Window | None
    moment_am2: float | None
    temperature_c: float | None
    blank: bool
    noise: bytes | None

    def __call__(self, tell: Callable[[float, str], None]) -> ShotFit:
        """Raises RecordingError."""
        from platform_daemon.estimation.calibration.validity import ShotConditions
        from platform_daemon.estimation.noise.series import SeriesNoise
        from platform_daemon.features.models.adopted_model import AdoptedModel

        from .calibrated import calibrated_signal, reason_of
        from .drive_hint import with_drive_hint
        from .fit import fit_signal, frame_report
        from .fit_request import FitRequest
        from .harmonics import shot_harmonics
        from .known_weight import recorded_weight_over_pull
        from .noise import learn_noise

        recording = open_recording(self.file)
        rx, rate_hz = recording.rx_volts(0), recording.sequence.rate_hz
        seen = None if self.blank else ShotHarmonics(shot_harmonics(rx, rate_hz, self.calibration))
        if self.window is None:
            return ShotFit(self.noise, seen)
        noise = SeriesNoise() if self.noise is None else pickle.loads(self.noise)
        choice = self.model.choice()
        undone = choice.receiver if isinstance(choice, AdoptedModel) else ()
        calibration = replace(self.calibration, receiver=undone)
        learn_noise(noise, rx, rate_hz, calibration, blank=self.blank)
        if self.blank:
            return ShotFit(pickle.dumps(noise), seen)
        weight = recorded_weight_over_pull(recording)
        ask = FitRequest(choice, self.window, moment_am2=self.moment_am2, weight_over_pull=weight)
        taken = ShotConditions(self.temperature_c, self.calibration.lna_gain)
        signal = calibrated_signal(rx, rate_hz, calibration)
        if not ask.of_rotor:
            fit = with_drive_hint(fit_signal(signal, ask, noise, calibration, taken), recording, 0)
            return ShotFit(pickle.dumps(noise), seen, frame_report(0, fit))
        try:
            frame = self._corrected(recording, ask, (signal, noise, calibration, taken))
        except RecordingError as error:
            frame = unfitted(0, reason_of(error))
        return ShotFit(pickle.dumps(noise), seen, frame)

    def _corrected(self, recording: Recording, ask: FitRequest, given: tuple[Any, ...]) -> FrameFit:
        """The fit of one angle, corrected for a manufacturing error.  Raises RecordingError, StorageError."""
        from .corrected import corrections_of
        from .drive_hint import with_drive_hint
        from .fit import fit_signal, frame_report

        signal, noise, calibration, taken = given
        assert self.model.library is not None  # where the model came from
        corrections = corrections_of(recording, ask, signal.record.valid_from, self.model.library)
        reports: list[CorrectionReport | None] = []

        def fitter(record: RingDownRecord, window: Window, of_shot: NoiseModel | None) -> FitResult:
            fit, report = corrections.fit(record, window, of_shot)
            reports.append(report)
            return fit

        fit = fit_signal(signal, ask.one_angle, noise, calibration, taken, fitter=fitter)
        frame = frame_report(0, with_drive_hint(fit, recording, 0))
        return frame.model_copy(update={"correction": reports[0]}) if frame.good and reports else frame


@dataclass(frozen=True)
class SeriesFits:
    """Table and report of the fits of a series."""

    table: FitTable
    report: FitReport


@dataclass(frozen=True)
class SeriesTable:
    """Puts the fits of a series together.  A task of the task executor.

    file: name of the recording; calibration: of the platform; fits: of its shots in order, or why there is none.
    """

    file: str
    model: NamedModel
    window: Window
    calibration: ReceiveCalibration
    fits: Sequence[FrameFit | str]

    def __call__(self, tell: Callable[[float, str], None]) -> SeriesFits:
        """Raises InputError for a model that is not there any more."""
        from .fit import file_report
        from .fit_request import FitRequest
        from .series_table import fit_table

        frames = [unfitted(k, fit) if isinstance(fit, str) else fit for k, fit in enumerate(self.fits)]
        ask = FitRequest(self.model.choice(), self.window)
        table = fit_table(str(self.window), self.model.label, frames)
        return SeriesFits(table, file_report(self.file, ask, frames, self.calibration))


@dataclass(frozen=True)
class Warmth:
    """Compiles or loads the estimator's kernels.  A task of the task executor.

    loads_only: nothing is done where they would have to be compiled, as another process does that already.
    """

    loads_only: bool = False

    def __call__(self, tell: Callable[[float, str], None]) -> float:
        """Seconds that it took."""
        collects = gc.isenabled()
        gc.disable()  # what it imports all stays: looking through it for garbage again and again takes a sixth of it
        try:
            from platform_daemon.estimation.compilation import is_compiled, warm_up

            return 0.0 if self.loads_only and not is_compiled() else warm_up()
        finally:
            gc.freeze()
            if collects:
                gc.enable()

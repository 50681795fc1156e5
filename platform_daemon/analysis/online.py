"""On-line fits of a running series: each from the file of its shot, by whichever process computes.

What a series has learned of its noise, and its fits, travel as bytes: the process that owns the hardware keeps them and
never looks inside, so it needs none of what they are made of.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon.schemas import FitReport, FrameFit, ShotHarmonics, Window, unfitted
from platform_daemon.store import FitTable, open_recording

if TYPE_CHECKING:
    from drivers.calibration import ReceiveCalibration

    from .model_registry.resolve import ModelChoice


@dataclass(frozen=True)
class NamedModel:
    """A model by its label, for a process that must not load what it is made of; library: folder of adopted models."""

    label: str
    library: Path | None = None

    def choice(self) -> ModelChoice:
        """The model.  Raises InputError if it is not there any more."""
        from .model_registry.library import Library
        from .model_registry.resolve import resolve

        found = resolve(self.label, None if self.library is None else Library(self.library))
        assert found is not None
        return found


@dataclass(frozen=True)
class CheckModel:
    """Is there such a model?  A task for whoever computes."""

    model: NamedModel

    def __call__(self, tell: Callable[[float, str], None]) -> NamedModel:
        """With the label that results are marked with.  Raises InputError, with the names there are."""
        from .fit_request import checked_variant
        from .model_registry.resolve import label_of

        found = self.model.choice()
        label = checked_variant(found) if isinstance(found, str) else label_of(found)
        return NamedModel(label, self.model.library)


@dataclass(frozen=True)
class ShotFit:
    """What a shot has brought.

    noise: what the series has learned, bytes for the next shot; harmonics: of an excited shot; fit: bytes for
    `SeriesTable`, None: none was asked for; frame: the same fit as told, its number is 0; values: parameters of a good
    fit by public name.
    """

    noise: bytes | None
    harmonics: ShotHarmonics | None
    fit: bytes | None = None
    frame: FrameFit | None = None


@dataclass(frozen=True)
class OnlineFit:
    """Reads a stored shot, learns from its noise and fits it.  A task for whoever computes.

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
        from platform_daemon.estimation import Conditions, SeriesNoise

        from .fit import fit_frame, frame_report
        from .fit_request import FitRequest
        from .harmonics import shot_harmonics
        from .model_registry.adopted_model import AdoptedModel
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
        ask = FitRequest(choice, self.window, moment_am2=self.moment_am2)
        taken = Conditions(self.temperature_c, self.calibration.lna_gain)
        fit = fit_frame(rx, rate_hz, calibration, ask, noise, taken)
        return ShotFit(pickle.dumps(noise), seen, pickle.dumps(fit), frame_report(0, fit))


@dataclass(frozen=True)
class SeriesFits:
    """Table and report of the fits of a series."""

    table: FitTable
    report: FitReport


@dataclass(frozen=True)
class SeriesTable:
    """Puts the fits of a series together.  A task for whoever computes.

    file: name of the recording; calibration: of the platform; fits: of its shots, or why there is none.
    """

    file: str
    model: NamedModel
    window: Window
    calibration: ReceiveCalibration
    fits: Sequence[bytes | str]

    def __call__(self, tell: Callable[[float, str], None]) -> SeriesFits:
        """Raises InputError for a model that is not there any more."""
        from .fit import file_report, frame_report
        from .fit_request import FitRequest
        from .series_table import fit_table

        fits = [fit if isinstance(fit, str) else pickle.loads(fit) for fit in self.fits]
        frames = [unfitted(k, fit) if isinstance(fit, str) else frame_report(k, fit) for k, fit in enumerate(fits)]
        ask = FitRequest(self.model.choice(), self.window)
        table = fit_table(str(self.window), self.model.label, fits)
        return SeriesFits(table, file_report(self.file, ask, frames, self.calibration))


@dataclass(frozen=True)
class Warmth:
    """Compiles or loads the estimator's kernels.  A task for whoever computes."""

    def __call__(self, tell: Callable[[float, str], None]) -> float:
        """Seconds that it took."""
        from platform_daemon.estimation import warm_up

        return warm_up()

"""What a worker does: open a recording, fit some of its frames, say it in the fixed JSON form."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivers.calibration import ReceiveCalibration
from platform_daemon.store import AngleSeries, Recording, is_time_series, open_recording, read_angles

from ..derived import frame_quantities, frame_times_s, series_quantities
from ..fit import fit_stored_frame, recording_report
from ..fit_request import FitRequest, Window, check_fixed, choose_variant
from ..frames import chosen_frames
from ..measurement import angle_variant, angles_report, fit_angles, refuse_calibration
from ..model_registry.resolve import ModelChoice


@dataclass(frozen=True, eq=False)
class FitSettings:
    """How to fit every file of a batch.

    Attributes:
        variant: a declared or an adopted model; None: what each file says.  terms: further torque terms.
        window: "n50", "d30" or seconds.
        fixed, hold_if_inseparable: parameters held, by name: always, or where the window cannot tell them.
        calibration: replaces the files' own; with where it came from.  None: the files' own.
        derived: give derived quantities too.
        frames: of every file; None: all.
    """

    variant: ModelChoice | None = None
    window: Window = "d30"
    fixed: dict[str, float] | None = None
    calibration: tuple[ReceiveCalibration, str] | None = None
    derived: bool = False
    hold_if_inseparable: dict[str, float] | None = None
    terms: tuple[str, ...] = ()
    frames: tuple[int, ...] | None = None


@dataclass(frozen=True)
class InputFile:
    """A recording: its path, and its content where workers cannot read that path."""

    path: Path
    content: bytes | None = None


@contextmanager
def opened(source: InputFile, settings: FitSettings) -> Iterator[tuple[Recording | AngleSeries, FitRequest]]:
    """The recording under the batch's calibration, or the angles, and what to ask of them.  Raises InputError."""
    with _readable(source) as path:
        yield _angles(path, settings) if is_time_series(path) else _recording(path, settings)


def _recording(path: Path, settings: FitSettings) -> tuple[Recording, FitRequest]:
    recording = open_recording(path)
    if settings.calibration is not None:
        recording = recording.with_calibration(*settings.calibration)
    recording, variant = choose_variant(recording, settings.variant, settings.terms)
    return recording, _asked(variant, settings, calibrated=recording.calibration is not None)


def _angles(path: Path, settings: FitSettings) -> tuple[AngleSeries, FitRequest]:
    series = read_angles(path)
    refuse_calibration(series, settings.calibration)
    variant = angle_variant(series, settings.variant, settings.terms)
    return series, _asked(variant, settings, calibrated=False)


def _asked(variant: ModelChoice, settings: FitSettings, *, calibrated: bool) -> FitRequest:
    """Raises InputError for what cannot be held."""
    ask = FitRequest(variant, settings.window, settings.fixed, settings.hold_if_inseparable)
    check_fixed(ask, calibrated=calibrated)
    return ask


@contextmanager
def _readable(source: InputFile) -> Iterator[Path]:
    """A path that this machine can read."""
    if source.content is None:
        yield source.path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, source.path.name)
        copy.write_bytes(source.content)
        yield copy


def count_frames(source: InputFile, settings: FitSettings) -> int:
    """Frames of a recording that can be fitted as asked.  Raises InputError."""
    with opened(source, settings) as (recording, _):
        return len(chosen_frames(recording, settings.frames))


def fit_part(source: InputFile, settings: FitSettings, first: int, last: int) -> list[dict[str, Any]]:
    """Reports of the chosen frames number first .. last-1.  Raises InputError."""
    with opened(source, settings) as (recording, ask):
        part = chosen_frames(recording, settings.frames)[first:last]
        return [_fit_frame(recording, k, ask, settings.derived) for k in part]


def _fit_frame(recording: Recording | AngleSeries, k: int, ask: FitRequest, derived: bool) -> dict[str, Any]:
    frame = fit_angles(recording, ask) if isinstance(recording, AngleSeries) else fit_stored_frame(recording, k, ask)
    return {**frame, "derived": frame_quantities(ask.model, frame)} if derived else frame


def put_together(source: InputFile, settings: FitSettings, frames: list[dict[str, Any]]) -> dict[str, Any]:
    """The report of a file from those of all its frames.  Raises InputError if no frame could be read."""
    with opened(source, settings) as (recording, ask):
        if isinstance(recording, AngleSeries):
            found = angles_report(recording, ask, frames)
            times_s: list[float | None] = [0.0]
        else:
            found, times_s = recording_report(recording, ask, frames), frame_times_s(recording)
        report = {**found, "file": str(source.path)}
        if settings.derived:
            report["derived"] = series_quantities(report, times_s)
        return report


def fit_whole(source: InputFile, settings: FitSettings) -> dict[str, Any]:
    """The report of a whole file.  Raises InputError."""
    return put_together(source, settings, fit_part(source, settings, 0, count_frames(source, settings)))

"""What a request waits for, as functions of what can be sent to another process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from drivers.errors import InputError
from platform_daemon.core.schemas.base import NamedWindow
from platform_daemon.core.schemas.derived import DerivedReport, EnvelopesReport
from platform_daemon.core.schemas.fits import FitReport, FrameFit
from platform_daemon.core.schemas.harmonics import ShotHarmonics
from platform_daemon.estimation.sliding_window import SlidingBounds
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.resolve import model_of, resolve

from .derived import derived_report, frame_envelopes
from .frame_plot import frame_plot
from .frame_plot_schema import FramePlot
from .harmonics import frame_harmonics
from .measurement import open_measurement, open_voltages
from .plot_data import RingDownPlotData, ring_down_plot_data
from .sliding import slide_frame, sliding_report
from .sliding_schema import SlidingReport


def preview_derived(report: FitReport, recording: Path, models: Library) -> DerivedReport:
    """Derived quantities of a stored fit.  Raises InputError for a model that was adopted elsewhere, RecordingError."""
    measurement = open_measurement(recording)
    variant = resolve(report.variant, models)
    assert variant is not None
    return derived_report(model_of(variant), report.frames, measurement.times_s())


def preview_envelopes(frame: FrameFit, model: str, models: Library, points: int, where: str) -> EnvelopesReport:
    """Envelopes of a fitted frame.  Raises InputError: a model that was adopted elsewhere, or no calibration."""
    variant = resolve(model, models)
    assert variant is not None
    try:
        return frame_envelopes(model_of(variant), frame, points)
    except ValueError as error:
        raise InputError("no envelopes", where=where, why=str(error), remedy="fit with a calibration") from None


def preview_sliding(
    recording: Path,
    frame: int,
    variant: str | None,
    window_s: float | None,
    step_s: float | None,
    damping: Literal["auto", "free", "fixed"],
    terms: Sequence[str],
    most: tuple[int, int],
) -> SlidingReport:
    """Sliding windows along one ring-down; most: fits, and samples of all windows.  Raises InputError."""
    bounds, measurement = SlidingBounds(windows=most[0], samples=most[1]), open_measurement(recording)
    found = slide_frame(measurement, frame, variant, window_s, step_s, damping, terms=terms, bounds=bounds)
    return sliding_report(found)


def preview_harmonics(recording: Path, frame: int) -> ShotHarmonics:
    """Harmonics of a frame.  Raises InputError, RecordingError."""
    return ShotHarmonics(frame_harmonics(open_voltages(recording), frame))


def preview_picture(
    recording: Path, frame: int, variant: str | None, models: Library, window: NamedWindow, title: str
) -> RingDownPlotData:
    """What to draw of a frame.  Raises InputError, RecordingError."""
    drawn = ring_down_plot_data(open_voltages(recording), frame, resolve(variant, models), window)
    return replace(drawn, title=title)


def preview_plot(
    recording: Path,
    frame: int,
    variant: str | None,
    models: Library,
    window: NamedWindow,
    points: int,
    stretch_s: tuple[float, float | None],
) -> FramePlot:
    """A stretch of a frame as numbers to draw.  Raises InputError, RecordingError."""
    drawn = ring_down_plot_data(open_voltages(recording), frame, resolve(variant, models), window)
    return frame_plot(drawn, frame, points, *stretch_s, where="start_s, stop_s")

"""From the signal of a frame to its fit, and from a file to the fits of its frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from statistics import fmean, median, mode

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError, PlatformError, RecordingError
from platform_daemon.core.schemas.fits import (
    Covariance,
    FitReport,
    FrameFit,
    NoiseReport,
    ParameterEstimate,
    unfitted,
)
from platform_daemon.estimation.calibration.uncertainty import systematic_std
from platform_daemon.estimation.calibration.validity import ShotConditions, out_of_validity
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.one_angle_error import with_one_angle_error
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.estimation.result import FitResult
from platform_daemon.estimation.screening.windows import Window
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.resolve import notes_of

from .calibrated import FrameSignal, calibrated_signal, reason_of
from .derived import frame_quantities, series_quantities
from .fit_request import FitRequest
from .fit_with_rotor import HOLDABLE, Refinement, unchanged, with_rotor
from .frames import chosen_frames
from .known_moment import implausible_moment
from .measurement import Measurement, VoltageMeasurement
from .rotor_context import rotor_context
from .series.summary import summary

Fitter = Callable[[RingDownRecord, Window, NoiseModel | None], FitResult]
FittedFrame = tuple[FrameFit, PlatformError | None]
"""A frame's fit; with the error of one that could not be read."""


def fit_frame(
    rx_volts: NDArray[np.float64],
    rate_hz: float,
    calibration: ReceiveCalibration | None,
    ask: FitRequest,
    noise: SeriesNoise | None = None,
    taken: ShotConditions | None = None,
) -> FitResult:
    """Calibrate and fit one RX window, (c, n) V; see fit_signal.  Raises RecordingError if they do not go together."""
    return fit_signal(calibrated_signal(rx_volts, rate_hz, calibration), ask, noise, calibration, taken)


def fit_signal(
    signal: FrameSignal,
    ask: FitRequest,
    noise: SeriesNoise | None = None,
    calibration: ReceiveCalibration | None = None,
    taken: ShotConditions | None = None,
    refine: Refinement = unchanged,
    fitter: Fitter | None = None,
) -> FitResult:
    """Fit a frame; refused if its raw volts are clipped, whatever the calibration mixes.

    noise: of the series that the frame belongs to; None: the frame's own.  taken: under which conditions, for the
    warnings about a calibration that does not hold for them.  refine: what is made of the fit of one angle; fitter:
    fits in the place of `fit_ring_down`, None: it does.  What the calibration's uncertainty does is
    in `systematic_std`.
    """
    try:
        signal.refuse_nothing()
        clipped = signal.harmless_clipping()
    except RefusedError as refused:
        return FitResult.refused(refused)
    of_shot = (noise or SeriesNoise()).for_shot(signal.record)
    if fitter is None:
        held = {"fixed": ask.fixed, "hold_if_inseparable": ask.hold_if_inseparable}
        fit = fit_ring_down(signal.record, ask.ring_down_model, ask.window, noise=of_shot.model, **held)
    else:
        fit = fitter(signal.record, ask.window, of_shot.model)
    fit = refine(signal.record, of_shot.model, fit)
    notes = (*fit.notes, *signal.notes, *([of_shot.note] if of_shot.note else []))
    fit = replace(fit, notes=notes, noise_seconds=fit.noise_seconds + of_shot.seconds)
    if not fit.parameters:
        return fit
    few = () if clipped is None else (f"saturated: {clipped}, too few to spoil the result",)
    said = out_of_validity(calibration, fit.parameters["f_nat_hz"].value, taken or ShotConditions())
    warnings = (*fit.warnings, *few, *signal.without_a_reading(), *said, *implausible_moment(fit, ask.moment_am2))
    return replace(fit, warnings=warnings, systematic_std=systematic_std(calibration, fit))


def fit_stored_frame(measurement: Measurement, k: int, ask: FitRequest, *, derived: bool = False) -> FittedFrame:
    """One frame of a file: fitted, blank, or refused by the daemon or for bad samples."""
    excuse = measurement.excuse(k)
    if excuse is not None:
        fitted: FittedFrame = unfitted(k, excuse), None
    else:
        try:
            fitted = frame_report(k, fit_frame_of(measurement, k, ask)), None
        except PlatformError as error:
            fitted = unfitted(k, reason_of(error)), error
    if not derived:
        return fitted
    return fitted[0].model_copy(update={"derived": frame_quantities(ask.ring_down_model, fitted[0])}), fitted[1]


def fit_frame_of(measurement: Measurement, k: int, ask: FitRequest) -> FitResult:
    """The fit of frame `k`.  Raises PlatformError for a frame that cannot be read or calibrated."""
    refine, one_angle = _refinement(measurement, k, ask), ask.one_angle
    signal = measurement.signal(k)
    began = time.perf_counter()
    noise = measurement.noise()
    found_s = time.perf_counter() - began
    given = noise, measurement.calibration, measurement.conditions(k)
    fit = measurement.with_hint(k, fit_signal(signal, one_angle, *given, refine))
    return replace(fit, noise_seconds=fit.noise_seconds + found_s)


def _refinement(measurement: Measurement, k: int, ask: FitRequest) -> Refinement:
    """What is made of the fit of one angle: that of a rotor with a manufacturing error, or its errors are widened.

    Raises RecordingError.
    """
    if not isinstance(ask.model, AdoptedModel) or ask.model.rotor is None:
        return _with_side_modes(measurement, k, ask)
    if not isinstance(measurement, VoltageMeasurement):
        why, remedy = "an angle tells nothing of the drive and of the other four degrees", f"fit {ask.model.base}"
        raise RecordingError(f"{ask.label} cannot be used here", where=str(measurement.path), why=why, remedy=remedy)
    if ask.hold_if_inseparable or not {*(ask.fixed or {})} <= {*HOLDABLE}:
        why = f"beside what was adopted, the rotor's fit holds only {', '.join(HOLDABLE)}, and always"
        remedy = "leave --hint and other names of --fix out"
        raise InputError(f"{ask.label} cannot be used here", where="fixed", why=why, remedy=remedy)
    return with_rotor(measurement.recording, k, ask.model, ask.fixed or {})


def _with_side_modes(measurement: Measurement, k: int, ask: FitRequest) -> Refinement:
    """Errors with what one angle leaves out of a jewel's rotor, where it has a weight and its drive is known."""
    if not ask.weight_over_pull or not isinstance(measurement, VoltageMeasurement) or measurement.calibration is None:
        return unchanged
    known, model = rotor_context(measurement.recording, k), ask.ring_down_model
    if known is None:
        return unchanged
    return lambda record, noise, fit: with_one_angle_error(fit, record, noise, model, known)


def fit_measurement(
    measurement: Measurement,
    ask: FitRequest,
    chosen: Sequence[int] | None = None,
    *,
    progress: Callable[[int], None] = lambda frames: None,
) -> FitReport:
    """Fit every frame of a file, or those chosen; one bad frame does not stop the others.

    Raises InputError for a frame that does not exist, RecordingError if none can be read.
    """
    fitted = []
    for done, k in enumerate(chosen_frames(measurement, chosen), start=1):
        fitted.append(fit_stored_frame(measurement, k, ask))
        progress(done)
    return measurement_report(measurement, ask, fitted)


def measurement_report(
    measurement: Measurement, ask: FitRequest, fitted: Sequence[FittedFrame], *, derived: bool = False
) -> FitReport:
    """The report of a file from its frames, in order.  Raises what kept the first one from being read, if none was."""
    errors = [error for _, error in fitted if error is not None]
    if errors and len(errors) == len(fitted):
        raise errors[0]
    frames = [frame for frame, _ in fitted]
    report = file_report(str(measurement.path), ask, frames, measurement.calibration, measurement.notes)
    sources = measurement.value_sources([frame.frame for frame in frames])
    report = report.model_copy(update={"value_sources": sources or None})
    if not derived:
        return report
    return report.model_copy(update={"derived": series_quantities(frames, measurement.times_s())})


def covariance_of(fit: FitResult) -> Covariance | None:
    """Covariance of what was estimated; None if the fit was refused."""
    if not fit.covariance_names:
        return None
    return Covariance(parameters=fit.covariance_names, matrix=tuple(map(tuple, fit.covariance.tolist())))


def frame_report(frame: int, fit: FitResult) -> FrameFit:
    """One frame of the report."""
    return FrameFit(
        frame=frame,
        verdict=fit.verdict,
        reason=fit.reason,
        parameters={name: ParameterEstimate(**asdict(e)) for name, e in fit.parameters.items()},
        covariance=covariance_of(fit),
        systematic_std=fit.systematic_std,
        r2=fit.r2,
        nrmse=fit.nrmse,
        chi2_per_dof=fit.chi2_per_dof,
        chi2_per_dof_by_channel=fit.chi2_per_dof_by_channel,
        whiteness_by_channel=fit.whiteness_by_channel,
        condition=fit.condition,
        window_s=fit.window_s,
        samples=fit.samples,
        warnings=fit.warnings,
        notes=fit.notes,
        seconds=fit.seconds,
        noise=NoiseReport(source=fit.noise_source, seconds=fit.noise_seconds),
    )


def file_report(
    file: str,
    ask: FitRequest,
    frames: Sequence[FrameFit],
    calibration: ReceiveCalibration | None,
    notes: Iterable[str] = (),
) -> FitReport:
    """The report of a file from those of its frames; notes: what holds for all of them."""
    windows = [f.window_s for f in frames if f.good and f.window_s is not None]
    return FitReport(
        file=str(Path(file)),
        variant=ask.label,
        window=ask.window,
        window_s=median(windows) if windows else None,
        calibration=None if calibration is None else calibration.identifier,
        notes=(*notes_of(ask.model), *notes),
        noise=_noise_report(frames),
        frames=tuple(frames),
        summary=summary(frames),
        systematic_std=_systematic_summary(frames),
    )


def _systematic_summary(frames: Sequence[FrameFit]) -> dict[str, float]:
    """The calibration's share in the error of each mean: the same in all frames, so that no mean makes it less."""
    systematic = [f.systematic_std for f in frames if f.systematic_std]
    return {name: fmean(std[name] for std in systematic) for name in (systematic[0] if systematic else ())}


def _noise_report(frames: Sequence[FrameFit]) -> NoiseReport:
    """Where the noise of most frames came from, and the time spent on it, which is not in that of the fits."""
    sources = [f.noise.source for f in frames if f.noise.source is not None]
    return NoiseReport(source=mode(sources) if sources else None, seconds=sum(f.noise.seconds for f in frames))

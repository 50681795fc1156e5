"""From a recording to fits: calibrate, estimate the noise, fit every frame, and say it in the fixed JSON form."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean, median, mode
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import PlatformError
from platform_daemon import __version__
from platform_daemon.estimation import (
    Conditions,
    FitResult,
    RefusedError,
    RingDownRecord,
    SeriesNoise,
    fit_ring_down,
    model_signal,
    out_of_validity,
    systematic_std,
)
from platform_daemon.store import FitTable, Recording

from .calibrated import checked_clipping, reason_of, ring_down
from .fit_request import FitRequest, Window, check_fixed, choose_variant, names_in_order
from .frames import chosen_frames
from .model_registry.resolve import ModelChoice, notes_of
from .noise import recording_noise
from .plot_data import RingDownPlotData
from .series.summary import summary


def fit_frame(
    rx_volts: NDArray[np.float64],
    rate_hz: float,
    calibration: ReceiveCalibration | None,
    ask: FitRequest,
    noise: SeriesNoise | None = None,
    taken: Conditions | None = None,
) -> FitResult:
    """Calibrate and fit one RX window, (c, n) V; refused if the volts are clipped, whatever the calibration mixes.

    noise: of the series that the frame belongs to; None: the frame's own.  taken: under which conditions, for the
    warnings about a calibration that does not hold for them.  What its uncertainty does is in `systematic_std`.
    """
    fit = _fit_record(rx_volts, ring_down(rx_volts, rate_hz, calibration), ask, noise)
    f_nat = fit.parameters.get("f_nat_hz")
    said = out_of_validity(calibration, None if f_nat is None else f_nat.value, taken or Conditions())
    if not fit.parameters:
        return fit
    return replace(fit, warnings=(*fit.warnings, *said), systematic_std=systematic_std(calibration, fit))


def _fit_record(
    rx_volts: NDArray[np.float64],
    calibrated: tuple[RingDownRecord, tuple[str, ...]],
    ask: FitRequest,
    noise: SeriesNoise | None,
) -> FitResult:
    """Fit a record, calibrated from these volts with these assumptions."""
    try:
        clipped = checked_clipping(rx_volts)
    except RefusedError as refused:
        return FitResult.refused(refused)
    record, assumed = calibrated
    of_shot = (noise or SeriesNoise()).for_shot(record)
    fit = fit_ring_down(
        record, ask.model, ask.window, noise=of_shot.model, fixed=ask.fixed, hold_if_inseparable=ask.hold_if_inseparable
    )
    notes = (*fit.notes, *assumed, *([of_shot.note] if of_shot.note else []))
    few = (f"saturated: {clipped}, too few to spoil the result",) if clipped is not None and fit.parameters else ()
    return replace(fit, warnings=(*fit.warnings, *few), notes=notes, noise_seconds=fit.noise_seconds + of_shot.seconds)


def frame_report(frame: int, fit: FitResult) -> dict[str, Any]:
    """One frame in the fixed JSON form, plus notes, warnings, chi2 by channel and where the noise came from."""
    return {
        "frame": frame,
        "verdict": fit.verdict,
        "reason": fit.reason,
        "parameters": {n: {"value": e.value, "std": e.std} for n, e in fit.parameters.items()},
        "systematic_std": dict(fit.systematic_std),
        "r2": fit.r2,
        "nrmse": fit.nrmse,
        "chi2_per_dof": fit.chi2_per_dof,
        "chi2_per_dof_by_channel": None if fit.chi2_per_dof_by_channel is None else list(fit.chi2_per_dof_by_channel),
        "whiteness_by_channel": None if fit.whiteness_by_channel is None else list(fit.whiteness_by_channel),
        "condition": fit.condition,
        "window_s": fit.window_s,
        "samples": fit.samples,
        "warnings": list(fit.warnings),
        "notes": list(fit.notes),
        "seconds": fit.seconds,
        "noise": {"source": fit.noise_source, "seconds": fit.noise_seconds},
    }


_QUALITY = (
    *("r2", "nrmse", "chi2_per_dof", "chi2_per_dof_by_channel", "whiteness_by_channel", "condition", "window_s"),
)


def refused_report(frame: int, reason: str) -> dict[str, Any]:
    """A frame that could not even be offered to the fit."""
    empty = dict.fromkeys(_QUALITY, None)
    base = {
        "frame": frame,
        "verdict": "refused",
        "reason": reason,
        "parameters": {},
        "systematic_std": {},
        "samples": 0,
    }
    noise = {"source": None, "seconds": 0.0}
    return {**base, **empty, "warnings": [], "notes": [], "seconds": 0.0, "noise": noise}


def fit_recording(
    recording: Recording,
    ask: FitRequest,
    chosen: Sequence[int] | None = None,
    *,
    progress: Callable[[int], None] = lambda frames: None,
) -> dict[str, Any]:
    """Fit every excited frame of a recording, or those chosen; the fixed JSON form for one file.

    Frames that the daemon refused, blank shots and frames with bad samples are refused with their reason; one bad
    frame does not stop the others.  Raises InputError if the fit makes no sense or no frame can be read.
    """
    check_fixed(ask, calibrated=recording.calibration is not None)
    frames = []
    for done, k in enumerate(chosen_frames(recording, chosen), start=1):
        frames.append(fit_stored_frame(recording, k, ask))
        progress(done)
    return recording_report(recording, ask, frames)


def fit_stored_frame(recording: Recording, k: int, ask: FitRequest) -> dict[str, Any]:
    """One frame of a recording, fitted or refused; one that cannot be read carries its error for recording_report."""
    info = recording.frame_info[k]
    if info.verdict != "good" or info.blank:
        return refused_report(k, "a blank shot, without excitation" if info.blank else info.reason)
    try:
        volts = recording.rx_volts(k)
    except PlatformError as error:
        return {**refused_report(k, reason_of(error)), "error": error}
    began = time.perf_counter()
    noise = recording_noise(recording)
    found_s = time.perf_counter() - began
    taken = Conditions(info.temperature_c, recording.lna_gain)
    fit = fit_frame(volts, recording.sequence.rate_hz, recording.calibration, ask, noise, taken)
    return frame_report(k, replace(fit, noise_seconds=fit.noise_seconds + found_s))


def recording_report(recording: Recording, ask: FitRequest, frames: list[dict[str, Any]]) -> dict[str, Any]:
    """The fixed JSON form for one file from its frames, in order.  Raises RecordingError if none can be read."""
    unreadable = [f["error"] for f in frames if "error" in f]
    if len(unreadable) == len(frames):
        raise unreadable[0]
    said = [{k: v for k, v in f.items() if k != "error"} for f in frames]
    return file_report(str(recording.path), ask, said, recording.calibration)


def file_report(
    file: str, ask: FitRequest, frames: list[dict[str, Any]], calibration: ReceiveCalibration | None
) -> dict[str, Any]:
    """The fixed JSON form for one file from its frames' reports."""
    windows = [f["window_s"] for f in frames if f["verdict"] == "good"]
    notes = notes_of(ask.variant)
    if calibration is None:
        notes.append(
            "no calibration: only voltage-domain quantities can be estimated (f_nat, lambda, T_f/I, phi_max, psi)"
        )
    return {
        "file": str(Path(file)),
        "variant": ask.label,
        "window": ask.window,
        "window_s": median(windows) if windows else None,
        "calibration": None if calibration is None else calibration.identifier,
        "notes": notes,
        "noise": _noise_report(frames),
        "frames": frames,
        "summary": summary(frames),
        "systematic_std": _systematic_summary(frames),
    }


def _systematic_summary(frames: list[dict[str, Any]]) -> dict[str, float]:
    """The calibration's share in the error of each mean: the same in all frames, so that no mean makes it less."""
    told = [f["systematic_std"] for f in frames if f["systematic_std"]]
    return {name: fmean(f[name] for f in told) for name in (told[0] if told else ())}


def _noise_report(frames: list[dict[str, Any]]) -> dict[str, Any]:
    """Where the noise of most frames came from, and the time spent on it, which is not in that of the fits."""
    sources = [f["noise"]["source"] for f in frames if f["noise"]["source"] is not None]
    return {"source": mode(sources) if sources else None, "seconds": sum(f["noise"]["seconds"] for f in frames)}


def fit_table(name: str, variant: str, fits: list[FitResult | str]) -> FitTable:
    """On-line fits of a series as the store keeps them; a text stands for a frame without a fit and says why."""
    good = [f for f in fits if isinstance(f, FitResult) and f.verdict == "good"]
    names = tuple(names_in_order({name for f in good for name in f.parameters}))
    rows = [_table_row(fit, names) for fit in fits]
    columns = {key: np.array([row[key] for row in rows], dtype=float) for key in _TABLE_COLUMNS}
    return FitTable(
        name=name,
        parameters=names,
        values=columns["values"].reshape(len(fits), len(names)),
        std=columns["std"].reshape(len(fits), len(names)),
        covariance=columns["covariance"].reshape(len(fits), len(names), len(names)),
        r2=columns["r2"],
        nrmse=columns["nrmse"],
        chi2_per_dof=columns["chi2_per_dof"],
        window_s=columns["window_s"],
        verdict=tuple("refused" if isinstance(f, str) else f.verdict for f in fits),
        reason=tuple(f if isinstance(f, str) else f.reason or "" for f in fits),
        variant=variant,
        software_version=__version__,
    )


_TABLE_COLUMNS = ("values", "std", "covariance", "r2", "nrmse", "chi2_per_dof", "window_s")


def _table_row(fit: FitResult | str, names: tuple[str, ...]) -> dict[str, Any]:
    """One frame's numbers, NaN where there is none."""
    k = len(names)
    covariance = np.full((k, k), np.nan)
    if isinstance(fit, str) or fit.verdict != "good":
        nothing = dict.fromkeys(_TABLE_COLUMNS[3:], np.nan)
        return {"values": [np.nan] * k, "std": [np.nan] * k, "covariance": covariance, **nothing}
    free = [names.index(n) for n in fit.covariance_names]
    covariance[np.ix_(free, free)] = fit.covariance
    estimates = [fit.parameters.get(n) for n in names]
    return {
        "values": [np.nan if e is None else e.value for e in estimates],
        "std": [np.nan if e is None or e.std is None else e.std for e in estimates],
        "covariance": covariance,
        "r2": fit.r2,
        "nrmse": fit.nrmse,
        "chi2_per_dof": fit.chi2_per_dof,
        "window_s": fit.window_s,
    }


def ring_down_plot_data(
    recording: Recording, frame: int, variant: ModelChoice | None, window: Window, terms: Sequence[str] = ()
) -> RingDownPlotData:
    """What to draw of one frame: its calibrated signal with the fit over it, or without if the fit was refused."""
    recording, chosen = choose_variant(recording, variant, terms)
    rate = recording.sequence.rate_hz
    volts = recording.rx_volts(frame)
    taken = ring_down(volts, rate, recording.calibration)
    record, _ = taken
    ask = FitRequest(chosen, window)
    fit = _fit_record(volts, taken, ask, recording_noise(recording))
    good = fit.verdict == "good"
    n = record.samples.shape[1]
    calibrated = record.quantity == "dmdt"
    names = recording.provenance.channel_names if recording.provenance else ()
    return RingDownPlotData(
        title=f"{recording.path.name}, frame {frame}",
        caption=_caption(fit) if good else f"fit refused: {fit.reason}",
        unit="dm/dt / A m² s⁻¹" if calibrated else "ADC input / V",
        channels=tuple("xyz") if calibrated else names or tuple(str(c) for c in range(record.samples.shape[0])),
        sampling_rate_hz=rate,
        measured=record.samples,
        model=model_signal(fit, n, rate) if good else None,
        window_s=fit.window_s if good else None,
    )


def _caption(fit: FitResult) -> str:
    p = {n: e.value for n, e in fit.parameters.items()}
    damping = f", λ {p['lambda_per_s']:.4f} s⁻¹" if "lambda_per_s" in p else ""
    friction = f", T_f/I {p['tf_over_i_rad_per_s2']:.0f} rad/s²" if "tf_over_i_rad_per_s2" in p else ""
    moment = f", m_r {1e3 * p['m_r_am2']:.4f} mAm²" if "m_r_am2" in p else ""
    return (
        f"f_nat {p['f_nat_hz']:.4f} Hz{moment}{damping}{friction}, "
        f"φ_max {math.degrees(p['phi_max_rad']):.2f}°, ψ {math.degrees(p['psi_start_rad']):.1f}°, "
        f"χ²/dof {fit.chi2_per_dof:.3f}"
    )

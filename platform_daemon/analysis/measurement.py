"""Fits of angle files, in the fixed JSON form: one frame, with the angle's parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from drivers.calibration import ReceiveCalibration
from drivers.errors import RecordingError
from platform_daemon.estimation import RingDownRecord, fit_ring_down
from platform_daemon.store import AngleSeries

from .fit import file_report, frame_report
from .fit_request import FitRequest, checked_variant
from .model_registry.adopted_model import AdoptedModel
from .model_registry.resolve import ModelChoice, notes_of

PENDULUM = "thread"  # of which an angle is taken unless a variant is named


def angle_variant(series: AngleSeries, variant: ModelChoice | None, terms: Sequence[str] = ()) -> ModelChoice:
    """The caller's variant, else a pendulum, with further torque terms.

    Raises InputError for an unknown one, or for one that undoes effects of a receiver, which an angle has not.
    """
    if not isinstance(variant, AdoptedModel):
        return checked_variant(variant or PENDULUM, terms)
    if terms or variant.receiver:
        why = "it takes no further terms" if terms else "it undoes effects of a receiver, which an angle has not"
        remedy = "use a model of torques alone, without --with-term"
        raise RecordingError(f"{variant.label} cannot be used here", where=str(series.path), why=why, remedy=remedy)
    return variant


def angle_record(series: AngleSeries) -> RingDownRecord:
    """What a fit takes."""
    return RingDownRecord(series.angle_rad, series.sampling_rate_hz, "angle")


def refuse_calibration(series: AngleSeries, calibration: tuple[ReceiveCalibration, str] | None) -> None:
    """Raises RecordingError if one is given."""
    if calibration is not None:
        remedy = "leave --calibration out for this file"
        raise RecordingError("holds an angle, which no calibration applies to", where=str(series.path), remedy=remedy)


def fit_angles(series: AngleSeries, ask: FitRequest) -> dict[str, Any]:
    """The one frame of an angle file, fitted or refused."""
    fit = fit_ring_down(
        angle_record(series), ask.model, ask.window, fixed=ask.fixed, hold_if_inseparable=ask.hold_if_inseparable
    )
    return frame_report(0, replace(fit, notes=(*fit.notes, *series.clock)))


def angles_report(series: AngleSeries, ask: FitRequest, frames: list[dict[str, Any]]) -> dict[str, Any]:
    """The fixed JSON form for one angle file."""
    return {**file_report(str(series.path), ask, frames, None), "notes": notes_of(ask.variant)}

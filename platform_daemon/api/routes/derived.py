"""What follows from fits and plans: derived quantities, sliding windows, harmonics, predicted precision."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from fastapi import APIRouter, Query

from drivers.errors import InputError
from platform_daemon.analysis import (
    FitRefused,
    checked_variant,
    derived_report,
    frame_envelopes,
    frame_harmonics,
    model_of,
    open_measurement,
    open_voltages,
    planned_precision,
    resolve,
    slide_frame,
    sliding_report,
    why_refused,
)
from platform_daemon.engine import UnknownId
from platform_daemon.estimation import RingDownModel, SlidingBounds
from platform_daemon.schemas import (
    PAPER_DEFLECTION_DEG,
    DerivedReport,
    EnvelopesReport,
    FitReport,
    PredictionReport,
    PredictionRequest,
    ShotHarmonics,
    SlidingReport,
)
from platform_daemon.store import resolve as path_of

from ..context import Context, Frame, JobId, RecordingId, Shared
from ..costs import MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES, check_file, check_frame
from ..job_routes import result_of
from ..network.routes import GuardedRoute
from ..problems import problems

router = APIRouter(tags=["derived"], route_class=GuardedRoute)
Length = Annotated[float | None, Query(gt=0, le=1e6)]


@router.get("/fits/{identifier}/derived", summary="Derived quantities of a fit", responses=problems(404, 422))
def get_derived(identifier: JobId, context: Shared) -> DerivedReport:
    """Quality factors of every good frame, orientation errors (mean, best) and the Allan deviation of f_nat.

    Keys as `platform-daemon fit --derived` writes them.
    """
    report, recording = _report(identifier, context)
    measurement = open_measurement(path_of(context.recordings, recording))
    return derived_report(_model(report, context), report.frames, measurement.times_s())


@router.get(
    "/fits/{identifier}/frames/{frame}/envelopes", summary="Envelopes of a fitted frame", responses=problems(404, 422)
)
def get_envelopes(
    identifier: JobId, frame: Frame, context: Shared, points: Annotated[int, Query(ge=2, le=20_000)] = 200
) -> EnvelopesReport:
    """Envelopes of v and u, amplitude A(t) and f(t) - f_nat over the fitted window."""
    report, _ = _report(identifier, context)
    chosen = next((f for f in report.frames if f.frame == frame), None)
    where = f"{identifier}: frame {frame}"
    if chosen is None or not chosen.good:
        why = "it does not exist" if chosen is None else chosen.reason or ""
        raise InputError("the frame has no fit", where=where, why=why, remedy="choose a frame that is good")
    try:
        return frame_envelopes(_model(report, context), chosen, points)
    except ValueError as error:
        raise InputError("no envelopes", where=where, why=str(error), remedy="fit with a calibration") from None


def _model(report: FitReport, context: Context) -> RingDownModel:
    """The model that a stored fit used.  Raises InputError if it was adopted elsewhere."""
    variant = resolve(report.variant, context.models)
    assert variant is not None
    return model_of(variant)


def _report(identifier: str, context: Context) -> tuple[FitReport, str]:
    """(report, recording) of a fit with a good frame.  Raises UnknownId, InputError, FitRefused."""
    job = context.holder("fit").job("fit", identifier)
    report: FitReport = result_of(job, "fit anew")
    refused = why_refused(report.frames)
    if refused is not None:
        remedy = "see the reasons; another window, variant or calibration may do"
        raise FitRefused("every frame was refused", where=identifier, why=refused, remedy=remedy)
    return report, job.request.recording


@router.get(
    "/recordings/{identifier}/frames/{frame}/sliding", summary="Sliding-window fits", responses=problems(404, 422)
)
def get_sliding(
    identifier: RecordingId,
    frame: Frame,
    context: Shared,
    window_s: Length = None,
    step_s: Length = None,
    damping: Annotated[Literal["auto", "free", "fixed"], Query(alias="lambda")] = "auto",
    variant: Annotated[str | None, Query(min_length=1, max_length=100)] = None,
    term: Annotated[list[str] | None, Query(max_length=8)] = None,
) -> SlidingReport:
    """Fits along one ring-down, window by window; with a complete model the constants are flat.

    Default: windows of an eighth of D30 that do not overlap.  `lambda` of a jewel: held at the D30 value never
    (`free`), always (`fixed`), or where a window cannot tell it from the friction (`auto`).  Refused windows say why.
    """
    path = path_of(context.recordings, identifier)
    check_file(path)
    bounds = SlidingBounds(MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES)
    measurement, terms = open_measurement(path), term or ()
    found = slide_frame(measurement, frame, variant, window_s, step_s, damping, terms=terms, bounds=bounds)
    return sliding_report(found).model_copy(update={"recording": identifier, "frame": frame})


@router.get(
    "/recordings/{identifier}/frames/{frame}/harmonics", summary="Harmonics of a frame", responses=problems(404, 422)
)
def get_harmonics(identifier: RecordingId, frame: Frame, context: Shared) -> ShotHarmonics:
    """f_nat, m_r, amplitude, orientation and decay from the harmonics of the first 24 periods; constant cost."""
    measurement = open_voltages(path_of(context.recordings, identifier))
    check_frame(measurement.recording)
    found = frame_harmonics(measurement, frame)
    return ShotHarmonics(found.model_copy(update={"recording": identifier}))


@router.get("/live/harmonics", summary="Harmonics of the last shot", responses=problems(404))
def get_live_harmonics(context: Shared) -> ShotHarmonics:
    """The same of the last excited shot, milliseconds after it, while its series still runs."""
    latest = context.hardware.last_harmonics()
    if latest is None:
        raise UnknownId("no shot has been seen since the daemon started", remedy="start an acquisition")
    return latest


@router.post("/predict", summary="What a planned measurement can tell", responses=problems(415, 422))
def predict(body: PredictionRequest, context: Shared) -> PredictionReport:
    """Smallest standard deviations that a measurement can reach (Cramer-Rao bound, white noise), per window."""
    specimen = context.catalogue.resonators.named(body.resonator)
    deflection = body.phi_max_rad or math.radians(PAPER_DEFLECTION_DEG[specimen.variant])
    return planned_precision(
        specimen,
        body.windows,
        phi_max_rad=deflection,
        noise_am2_per_s=body.noise_am2_per_s,
        sampling_rate_hz=body.sampling_rate_hz,
        fixed=tuple(body.fixed),
        variant=checked_variant(body.variant or specimen.variant, body.terms),
        expected=body.expected,
    )

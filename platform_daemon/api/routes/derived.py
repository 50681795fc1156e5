"""What follows from fits and plans: derived quantities, sliding windows, harmonics, predicted precision."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Literal, TypeVar

from fastapi import APIRouter, Query, Response

from drivers.errors import InputError
from platform_daemon import analysis, reports  # not their parts: they load what only the workers and pictures need
from platform_daemon.engine import UnknownId
from platform_daemon.schemas import (
    PAPER_DEFLECTION_DEG,
    DerivedReport,
    EnvelopesReport,
    FitReport,
    NamedWindow,
    PredictionReport,
    PredictionRequest,
    ShotHarmonics,
    SlidingReport,
)
from platform_daemon.store import StoredFrame, read_frame
from platform_daemon.store import resolve as path_of
from platform_daemon.workers import Call

from ..context import Context, Frame, JobId, RecordingId, Shared
from ..costs import MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES, check_file
from ..job_routes import result_of
from ..network.routes import GuardedRoute
from ..problems import OWNER, problems
from .design import PNG

router = APIRouter(tags=["derived"], route_class=GuardedRoute)
FoundT = TypeVar("FoundT")
Length = Annotated[float | None, Query(gt=0, le=1e6)]


@router.get("/fits/{identifier}/derived", summary="Derived quantities of a fit", responses=problems(404, 422))
def get_derived(identifier: JobId, context: Shared) -> DerivedReport:
    """Quality factors of every good frame, orientation errors (mean, best) and the Allan deviation of f_nat.

    Keys as `platform-daemon fit --derived` writes them.
    """
    report, recording = _report(identifier, context)
    path = path_of(context.recordings, recording)
    return context.computed(Call(analysis.preview_derived, (report, path, context.models)))


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
    asked = chosen, report.variant, context.models, points, where
    return context.computed(Call(analysis.preview_envelopes, asked))


def _report(identifier: str, context: Context) -> tuple[FitReport, str]:
    """(report, recording) of a fit with a good frame.  Raises UnknownId, InputError, FitRefused."""
    job = context.holder("fit").job("fit", identifier)
    report: FitReport = result_of(job, "fit anew")
    refused = analysis.why_refused(report.frames)
    if refused is not None:
        remedy = "see the reasons; another window, variant or calibration may do"
        raise analysis.FitRefused("every frame was refused", where=identifier, why=refused, remedy=remedy)
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
    most = MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES
    how = variant, window_s, step_s, damping, tuple(term or ()), most
    found = _computed(context, identifier, frame, analysis.preview_sliding, *how)
    return found.model_copy(update={"recording": identifier, "frame": frame})


@router.get(
    "/recordings/{identifier}/frames/{frame}/harmonics", summary="Harmonics of a frame", responses=problems(404, 422)
)
def get_harmonics(identifier: RecordingId, frame: Frame, context: Shared) -> ShotHarmonics:
    """f_nat, m_r, amplitude, orientation and decay from the harmonics of the first 24 periods; constant cost."""
    found = _computed(context, identifier, frame, analysis.preview_harmonics)
    return ShotHarmonics(found.root.model_copy(update={"recording": identifier, "frame": frame}))


@router.get(
    "/recordings/{identifier}/frames/{frame}/picture",
    summary="A frame as a picture",
    response_class=Response,
    responses={**PNG, **problems(404, 422)},
)
def draw_frame(
    identifier: RecordingId,
    frame: Frame,
    context: Shared,
    window: NamedWindow = "d30",
    variant: Annotated[str | None, Query(min_length=1, max_length=100)] = None,
) -> Response:
    """PNG: dm/dt with the fit over it, the residual and the spectrum, as `platform-daemon plot` draws it.

    Also of a series that runs, as soon as the shot counts.
    """
    how = variant, context.models, window, f"{identifier}, frame {frame}"
    drawn = _computed(context, identifier, frame, analysis.preview_picture, *how)
    return Response(reports.ring_down_png(drawn), media_type="image/png")


@router.get("/live/harmonics", summary="Harmonics of the last shot", responses=problems(404, *OWNER))
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
    asked = {
        "phi_max_rad": deflection,
        "noise_am2_per_s": body.noise_am2_per_s,
        "sampling_rate_hz": body.sampling_rate_hz,
        "fixed": tuple(body.fixed),
        "variant": analysis.checked_variant(body.variant or specimen.variant, body.terms),
        "expected": body.expected,
    }
    return context.computed(Call(analysis.planned_precision, (specimen, body.windows), asked))


def _computed(context: Context, identifier: str, frame: int, what: Callable[..., FoundT], *how: object) -> FoundT:
    """Of a frame, from its file and its number there.  Raises UnknownRecording, RecordingError, TooCostly."""

    def read(stored: StoredFrame) -> FoundT:
        check_file(stored.path)
        return context.computed(Call(what, (stored.path, stored.frame, *how)))

    return read_frame(context.recordings, identifier, frame, read)

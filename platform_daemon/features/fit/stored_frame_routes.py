"""What follows from fits and plans: derived quantities, sliding windows, harmonics, predicted precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal, TypeVar

from fastapi import APIRouter, Query, Response

from drivers.errors import InputError
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.jobs.workers.task_executor import Call
from platform_daemon.core.recordings.index import resolve as path_of
from platform_daemon.core.recordings.running import StoredFrame, read_frame
from platform_daemon.core.schemas.base import NamedWindow
from platform_daemon.core.schemas.derived import DerivedReport, EnvelopesReport
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.harmonics import ShotHarmonics
from platform_daemon.core.web.context import Context, Frame, JobId, RecordingId, Shared
from platform_daemon.core.web.costs import MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES, check_file
from platform_daemon.core.web.job_routes import result_of
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.problems import OWNER, problems
from platform_daemon.core.web.ranged_file import PNG
from platform_daemon.features.models.library import Library

from .frame_plot_schema import FramePlot
from .prediction_schema import PredictionReport
from .request_schema import PredictionRequest
from .sliding_schema import SlidingReport

router = APIRouter(tags=["derived"], route_class=GuardedRoute)
FoundT = TypeVar("FoundT")
Length = Annotated[float | None, Query(gt=0, le=1e6)]


@router.get("/fits/{identifier}/derived", summary="Derived quantities of a fit", responses=problems(404, 422, 423))
def get_derived(identifier: JobId, context: Shared) -> DerivedReport:
    """Quality factors of every good frame, orientation errors (mean, best) and the Allan deviation of f_nat.

    Keys as `platform-daemon fit --derived` writes them.
    """
    from .previews import preview_derived

    report, recording = _report(identifier, context)
    path = path_of(context.folders.recordings, recording)
    return context.run(Call(preview_derived, (report, path, Library(context.folders.models))))


@router.get(
    "/fits/{identifier}/frames/{frame}/envelopes",
    summary="Envelopes of a fitted frame",
    responses=problems(404, 422, 423),
)
def get_envelopes(
    identifier: JobId, frame: Frame, context: Shared, points: Annotated[int, Query(ge=2, le=20_000)] = 200
) -> EnvelopesReport:
    """Envelopes of v and u, amplitude A(t) and f(t) - f_nat over the fitted window."""
    from .previews import preview_envelopes

    report, _ = _report(identifier, context)
    chosen = next((f for f in report.frames if f.frame == frame), None)
    where = f"{identifier}: frame {frame}"
    if chosen is None or not chosen.good:
        why = "it does not exist" if chosen is None else chosen.reason or ""
        raise InputError("the frame has no fit", where=where, why=why, remedy="choose a frame that is good")
    arguments = chosen, report.variant, Library(context.folders.models), points, where
    return context.run(Call(preview_envelopes, arguments))


def _report(identifier: str, context: Context) -> tuple[FitReport, str]:
    """(report, recording) of a fit with a good frame.  Raises UnknownId, InputError, FitRefused."""
    from .fit_request import FitRefused, without_fit

    job = context.jobs_of("fit").job("fit", identifier)
    report: FitReport = result_of(job, "submit a new fit")
    problem = without_fit(report.frames)
    if problem is not None:
        what, why = problem
        remedy = "see the reasons; another window, variant or calibration may do"
        raise FitRefused(what, where=identifier, why=why, remedy=remedy)
    return report, job.request.recording


@router.get(
    "/recordings/{identifier}/frames/{frame}/sliding", summary="Sliding-window fits", responses=problems(404, 422, 423)
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
    from .previews import preview_sliding

    most = MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES
    how = variant, window_s, step_s, damping, tuple(term or ()), most
    found = _computed(context, identifier, frame, preview_sliding, *how)
    return found.model_copy(update={"recording": identifier, "frame": frame})


@router.get(
    "/recordings/{identifier}/frames/{frame}/harmonics",
    summary="Harmonics of a frame",
    responses=problems(404, 422, 423),
)
def get_harmonics(identifier: RecordingId, frame: Frame, context: Shared) -> ShotHarmonics:
    """f_nat, m_r, amplitude, orientation and decay from the harmonics of the first 24 periods; constant cost."""
    from .previews import preview_harmonics

    found = _computed(context, identifier, frame, preview_harmonics)
    return ShotHarmonics(found.root.model_copy(update={"recording": identifier, "frame": frame}))


@router.get(
    "/recordings/{identifier}/frames/{frame}/picture",
    summary="A frame as a picture",
    response_class=Response,
    responses={**PNG, **problems(404, 422, 423)},
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
    from .previews import preview_picture
    from .ring_down_figure import ring_down_png

    how = variant, Library(context.folders.models), window, f"{identifier}, frame {frame}"
    drawn = _computed(context, identifier, frame, preview_picture, *how)
    return Response(ring_down_png(drawn), media_type="image/png")


@router.get(
    "/recordings/{identifier}/frames/{frame}/plot",
    summary="A frame with its fit as numbers to draw",
    responses=problems(404, 422),
)
def get_frame_plot(
    identifier: RecordingId,
    frame: Frame,
    context: Shared,
    window: NamedWindow = "d30",
    variant: Annotated[str | None, Query(min_length=1, max_length=100)] = None,
    points: Annotated[int, Query(ge=2, le=5000)] = 600,
    start_s: Annotated[float, Query(ge=0, le=1e6)] = 0.0,
    stop_s: Length = None,
) -> FramePlot:
    """Measured, model, residual in standard deviations of the noise, and spectra, of a stretch of the frame.

    What `/picture` draws, for pages that draw it themselves.  Also of a series that runs.
    """
    from .previews import preview_plot

    how = variant, Library(context.folders.models), window, points, (start_s, stop_s)
    return _computed(context, identifier, frame, preview_plot, *how)


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
    from .precision import planned_model, planned_precision

    specimen = context.catalogue.resonators.named(body.resonator)
    arguments = {
        "phi_max_rad": body.phi_max_rad,
        "noise_am2_per_s": body.noise_am2_per_s,
        "sampling_rate_hz": body.sampling_rate_hz,
        "fixed": tuple(body.fixed),
        "model": planned_model(body.variant, body.terms, Library(context.folders.models), specimen),
        "estimate_adopted": body.estimate_adopted,
        "expected": body.expected,
        "sequence": body.sequence,
    }
    return context.run(Call(planned_precision, (specimen, body.windows), arguments))


def _computed(context: Context, identifier: str, frame: int, what: Callable[..., FoundT], *how: object) -> FoundT:
    """Of a frame, from its file and its number there.  Raises UnknownRecording, RecordingError, TooCostly."""

    def read(stored: StoredFrame) -> FoundT:
        check_file(stored.path)
        return context.run(Call(what, (stored.path, stored.frame, *how)))

    return read_frame(context.folders.recordings, identifier, frame, read)

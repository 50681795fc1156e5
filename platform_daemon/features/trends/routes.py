"""What specimens do over months."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from platform_daemon.core.jobs.workers.task_executor import Call
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.web.context import Context, Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Paged
from platform_daemon.core.web.problems import problems

from .index_keeper import KEPT_POINTS, TrendKeeper
from .schema import Baseline, BaselineRequest, SpecimenListing, SpecimenPage, TrendReport
from .specimen_page import specimen_page
from .trend import POINTS_TO_FALSE_ALARM

router = APIRouter(prefix="/specimens", tags=["specimens"], route_class=GuardedRoute)
# A name may hold a slash: `:path`, and what comes after a name is looked for before the name alone.
PNG = {"schema": {"type": "string", "format": "binary"}}
TEXT = {"schema": {"type": "string"}}
Specimen = Annotated[
    str, Path(description="name of the sample, or of the resonator if none was given", examples=["T-07"])
]
Since = Annotated[
    str | None, Query(description="begin there, ISO 8601; the control charts restart there, too", max_length=40)
]
Until = Annotated[str | None, Query(description="end there, ISO 8601", max_length=40)]
Step = Annotated[
    str | None,
    Query(description="number or name of a step of procedures; left out: the last one", min_length=1, max_length=100),
]
Rate = Annotated[
    float, Query(ge=100, le=1e6, description="points to a false alarm, on average over all charts of a specimen")
]

Newest = Annotated[
    int | None,
    Query(ge=1, le=1_000_000, description="list at most so many points, the newest; the charts are those of all"),
]

Uncertainty = Annotated[
    bool, Query(description="U of every value, by a budget for each calibration, which takes some fits")
]


@router.get("", summary="Specimens that were measured", responses={**NEXT, **problems(422, 503)})
def list_specimens(context: Shared, page: Paged) -> SpecimenListing:
    """Names of all specimens with shots that were fitted, page by page."""
    from .indexed import indexed_specimens

    context.part(TrendKeeper).catch_up()
    here = tuple(page.of(indexed_specimens(context.folders.recordings)))
    return SpecimenListing(items=here, next=page.next)


@router.get(
    "/{specimen:path}/trend/picture",
    summary="Picture of a trend",
    response_class=Response,
    responses={200: {"content": {"image/png": PNG}, "description": "PNG"}, **problems(404, 422, 503)},
)
def get_trend_picture(
    specimen: Specimen,
    context: Shared,
    since: Since = None,
    until: Until = None,
    step: Step = None,
    points_to_false_alarm: Rate = POINTS_TO_FALSE_ALARM,
) -> Response:
    """Each quantity over the months, as measured and at one temperature, and its control chart."""
    from .figure import trend_png

    found = _trend(context, specimen, since, until, step, points_to_false_alarm)
    return Response(trend_png(found), media_type="image/png")


@router.get(
    "/{specimen:path}/trend/table",
    summary="Points of a trend as CSV",
    response_class=Response,
    responses={200: {"content": {"text/csv": TEXT}, "description": "CSV with a heading"}, **problems(404, 422, 503)},
)
def get_trend_table(
    specimen: Specimen,
    context: Shared,
    since: Since = None,
    until: Until = None,
    step: Step = None,
    uncertainty: Uncertainty = False,
) -> Response:
    """A row per point: when, recording, shots, temperature, each quantity as measured and at one temperature, clock."""
    from .report import trend_csv
    from .trend import POINTS_TO_FALSE_ALARM

    found = _trend(context, specimen, since, until, step, POINTS_TO_FALSE_ALARM, uncertainty=uncertainty)
    return Response(trend_csv(found), media_type="text/csv")


@router.get("/{specimen:path}/trend", summary="What a specimen does over months", responses=problems(404, 422, 503))
def get_trend(
    specimen: Specimen,
    context: Shared,
    since: Since = None,
    until: Until = None,
    step: Step = None,
    points_to_false_alarm: Rate = POINTS_TO_FALSE_ALARM,
    newest: Newest = None,
    uncertainty: Uncertainty = False,
) -> TrendReport:
    """Points of all recordings with on-line fits, a control chart per quantity, and changes by name."""
    return _trend(context, specimen, since, until, step, points_to_false_alarm, newest, uncertainty=uncertainty)


@router.get("/{specimen:path}", summary="What is known of a specimen", responses=problems(404, 422, 503))
def get_specimen(specimen: Specimen, context: Shared) -> SpecimenPage:
    """Recordings, resonators with their highest field and preset, calibrations, adopted models, changes, links."""
    context.part(TrendKeeper).catch_up()
    return specimen_page(specimen, context)


@router.post(
    "/{specimen:path}/baseline", summary="Accept a specimen as it is", responses=problems(404, 415, 422, 503, 507)
)
def accept_specimen(specimen: Specimen, body: BaselineRequest, context: Shared) -> Baseline:
    """Its charts restart, after its newest recording or from `since` on, and its alarms are over; `?since=` of a
    trend looks further back."""
    from .baseline import accept
    from .indexed import indexed_specimens, indexed_trend

    specimen = same_name(specimen)
    if specimen not in indexed_specimens(context.folders.recordings):
        indexed_trend(context.folders.recordings, specimen)  # which says so
    made = accept(context.folders.recordings, specimen, body)
    context.part(TrendKeeper).judge(specimen)
    return made


def _trend(
    context: Context,
    specimen: str,
    since: str | None,
    until: str | None,
    step: str | None,
    rate: float,
    newest: int | None = None,
    *,
    uncertainty: bool = False,
) -> TrendReport:
    """Raises UnknownSpecimen, InputError, StorageError, RecordingError."""
    from .indexed import indexed_trend
    from .readings import with_measurand

    keeper = context.part(TrendKeeper)
    keeper.catch_up()
    if uncertainty:
        how = (context.folders.recordings, specimen, since, until, rate, step, newest)
        found = context.run(Call(indexed_trend, how, {"uncertainty": True}))
    elif (since, until, step, rate, newest) == (None, None, None, POINTS_TO_FALSE_ALARM, KEPT_POINTS):
        found = keeper.trend(specimen)
    else:
        found = indexed_trend(context.folders.recordings, specimen, since, until, rate, step, newest)
    found = with_measurand(found, context.folders.recordings, context.folders.measurands)
    behind = keeper.behind
    if behind:
        found = found.model_copy(update={"notes": (*found.notes, f"{behind} recordings are still to be looked at")})
    return found

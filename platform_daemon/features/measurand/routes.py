"""Measurands: calibrations listed and shown, recordings read by them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query

from platform_daemon.core.jobs.workers.task_executor import Call
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.web.context import RecordingId, Shared
from platform_daemon.core.web.costs import check_file
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Paged
from platform_daemon.core.web.problems import problems, unreadable

from .library import Measurands
from .schema import MeasurandCalibration, MeasurandListing, MeasurandReport
from .stored import stored_readings

router = APIRouter(tags=["measurands"], route_class=GuardedRoute)
Label = Annotated[str, Path(description="KEY or KEY@VERSION of a calibration", examples=["paper-jewel-specimen@1"])]


@router.get("/measurands", summary="Resonators that are sensors", responses={**NEXT, **problems(422)})
def list_measurands(context: Shared, page: Paged) -> MeasurandListing:
    """Every version of every calibration, and every file that holds none with the reason."""
    kept, files = Measurands(context.folders.measurands).all()
    found, broken = {each.label: each for each in kept}, {each.id: each for each in files}
    here = set(page.of((*found, *(name for name in broken if name not in found))))
    return MeasurandListing(
        items=tuple(each for label, each in found.items() if label in here),
        broken=tuple(unreadable(each) for name, each in broken.items() if name in here),
        next=page.next,
    )


@router.get("/measurands/{name}", summary="A calibration of a measurand", responses=problems(404, 422))
def get_measurand(name: Label, context: Shared) -> MeasurandCalibration:
    """KEY@VERSION, or KEY: its newest version."""
    return Measurands(context.folders.measurands).get(name)


@router.get(
    "/recordings/{identifier}/measurand", summary="A recording as readings of a sensor", responses=problems(404, 422)
)
def read_measurand(
    identifier: RecordingId,
    context: Shared,
    calibration: Annotated[
        str | None, Query(min_length=1, max_length=100, description="KEY or KEY@VERSION; default: of the specimen")
    ] = None,
    coverage: Annotated[float, Query(gt=0, lt=1, description="probability of the interval")] = 0.95,
    extrapolate: Annotated[bool, Query(description="read outside of the range of the calibration, too")] = False,
) -> MeasurandReport:
    """Value and expanded uncertainty of every shot and of their mean."""
    path = resolve(context.folders.recordings, identifier)
    check_file(path)
    return context.run(Call(stored_readings, (path, context.folders.measurands, calibration, coverage, extrapolate)))

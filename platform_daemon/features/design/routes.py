"""What a design says of a resonator, and what manufacturing defects do to it; computed at once, nothing moves."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response

from drivers.specimen import Specimen
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.web.context import Context, Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.problems import problems
from platform_daemon.core.web.ranged_file import PNG

from .checked_defect import checked_defect
from .curves import force_curves
from .defects import defects_report
from .numbers import design_report
from .schema import DefectsReport, DefectsRequest, DesignReport

router = APIRouter(tags=["design"], route_class=GuardedRoute)
Name = Annotated[str, Path(description="NAME, or NAME@VERSION of what was added", examples=["jewel"])]


@router.get("/design", summary="The paper's design point")
def get_paper_design() -> DesignReport:
    """Moment, frequency, forces and friction by the paper's equations, and its six steps for both bearings."""
    return design_report()


@router.get("/resonators/{name}/design", summary="What the design of a resonator says", responses=problems(404, 422))
def get_design(name: Name, context: Shared) -> DesignReport:
    """The same of a resonator: what follows from its magnets and bearing alone, and what was measured.

    As `platform-daemon design --json` writes it.
    """
    shelf = context.catalogue.resonators
    if name not in shelf.files():
        raise UnknownId(f"no resonator is called {name!r}", where=name, remedy="GET /resonators lists all")
    return design_report(shelf.named(name))


@router.post("/defects", summary="What a manufacturing defect does", responses=problems(415, 422))
def compute_defects(body: DefectsRequest, context: Shared) -> DefectsReport:
    """Equivalent perpendicular force for every size of a defect at every deflection, at most 20 000 cases.

    As `platform-daemon defects --json` writes it.
    """
    return defects_report(checked_defect(body, _resonator(body.resonator, context)))


@router.post(
    "/defects/picture",
    summary="The same as a picture",
    response_class=Response,
    responses={**PNG, **problems(415, 422)},
)
def draw_defects(body: DefectsRequest, context: Shared) -> Response:
    """PNG like the paper's figures: force over the size of the defect, by deflection and by cup radius or thread."""
    from .figure import defects_png

    specimen = _resonator(body.resonator, context)
    checked = checked_defect(body, specimen)
    checked.analysed(body.sizes, body.phi_deg)
    return Response(defects_png(force_curves(checked, specimen)), media_type="image/png")


def _resonator(name: str | None, context: Context) -> Specimen | None:
    """None: the paper's design point.  Raises InputError."""
    return None if name is None else context.catalogue.resonators.named(name)

"""What the platform is and does: state, readiness, the kinds of problems."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import RedirectResponse

from drivers.errors import PlatformError
from platform_daemon import __version__
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.schemas.access import CallerInfo
from platform_daemon.core.schemas.platform import DeviceListing, EntryPoints, FaultReset, PlatformStatus, Readiness
from platform_daemon.core.schemas.problems import ProblemKind
from platform_daemon.core.schemas.unattended import (
    FaultCleared,
    FaultUnlock,
    MountedResonator,
    MountRequest,
    QueueOrder,
)
from platform_daemon.core.web.context import CONFIRMED, Confirmed, Context, Shared
from platform_daemon.core.web.kinds import problem_kinds
from platform_daemon.core.web.network.callers import Caller
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.problems import OWNER, problems

router = APIRouter(tags=["platform"], route_class=GuardedRoute)
PAGE = "page/"  # relative: the daemon may stand below a path of a proxy
PATHS = (
    *(
        "page",
        "caller",
        "jobs",
        "changes",
        "platform",
        "devices",
        "acquisitions",
        "procedures",
        "schedules",
        "events",
        "alarms",
        "metrics",
        "calibrations",
        "self-tests",
        "recordings",
        "fits",
        "diagnoses",
        "specimens",
    ),
    *(
        "characterisations",
        "reproductions",
        "models",
        "resonators",
        "sequences",
        "design",
        "health",
        "ready",
        "docs",
        "openapi.json",
    ),
)


@router.get("/", summary="Where everything is", response_model=EntryPoints)
def get_entry_points(request: Request, response: Response) -> EntryPoints | Response:
    """Entry points of the API; a browser, which asks for HTML, is led to the operator's page."""
    if "text/html" in request.headers.get("accept", ""):
        return RedirectResponse(PAGE, status_code=303, headers={"Vary": "Accept"})
    response.headers["Vary"] = "Accept"
    return EntryPoints(name="platform-daemon", version=__version__, links={p: f"/{p}" for p in PATHS})


@router.get("/caller", summary="Who asks, and what the caller may do")
def get_caller(request: Request) -> CallerInfo:
    """Name and role of the sender of the request; it is answered without a token too."""
    caller: Caller = request.state.caller
    refused = None if caller.refused is None else str(caller.refused)
    return CallerInfo(name=caller.name, role=caller.role, refused=refused)


_WAITING_FOR = {
    "platform": "the devices are being opened and read",
    "estimator": "the fit's kernels are being loaded, some seconds; the first start of an installation compiles them, "
    "about half a minute on an idle computer",
}


@router.get(
    "/ready",
    summary="Is everything warmed up?",
    responses={503: {"model": Readiness, "description": "Some parts have not warmed up"}},
)
def get_readiness(context: Shared, response: Response) -> Readiness:
    """200 once every part has warmed up, 503 before, naming the parts; requests are served all the same."""
    parts = _warm(context)
    response.status_code = 200 if all(parts.values()) else 503
    waiting = {part: _WAITING_FOR[part] for part, warm in parts.items() if not warm}
    return Readiness(ready=all(parts.values()), warm=parts, waiting_for=waiting)


def _warm(context: Context) -> dict[str, bool]:
    try:
        return context.hardware.warm()
    except PlatformError:  # it is being started, or its devices do not open, which GET /platform tells
        return {"platform": False, "estimator": False}


@router.get("/platform", summary="State of every device, and the job that runs", responses=problems(*OWNER))
def get_platform(context: Shared) -> PlatformStatus:
    """As last read back, at `read_at`: every second while idle, in the RX window of each shot of an acquisition."""
    return context.hardware.status()


@router.get(
    "/devices",
    summary="What is there: identity, state and last error of each device",
    responses=problems(*OWNER),
)
def list_devices(context: Shared) -> DeviceListing:
    """One entry per device, as last read back; one that does not answer is there with its error."""
    return context.hardware.devices()


@router.post(
    "/devices/power_amplifier/reset",
    summary="Clear the amplifier's latched fault after a trip",
    responses=problems(409, 415, 422, *OWNER),
)
def reset_amplifier(context: Shared, body: Confirmed = CONFIRMED) -> FaultReset:
    """Find the cause of the trip first.

    Puts no power out: the amplifier is disabled and muted afterwards, and the next series begins with its self-test.
    409 while a series or a calibration runs; 502 if the fault stays, because its cause persists or the amplifier has
    no reset command.  Without a fault there is nothing to clear: `fault` is null.
    """
    return context.hardware.reset_fault()


@router.post(
    "/platform/fault/reset",
    summary="Clear the fault that an owner of the devices has left by its death",
    responses=problems(409, 415, 422, *OWNER),
)
def reset_fault(context: Shared, body: FaultUnlock) -> FaultCleared:
    """After a person has looked at the platform: until then no series, calibration or procedure is accepted.

    Proves all outputs off first; no power goes out.  409 while a series or a calibration runs.  Without a fault there
    is nothing to clear: `fault` is null.
    """
    return context.hardware.unlock(body)


@router.post("/platform/queue", summary="Put what waits in order", responses=problems(409, 415, 422, *OWNER))
def order_queue(context: Shared, body: QueueOrder) -> PlatformStatus:
    """The jobs of `order` first; all others follow by their priority.  `queued` of the answer is the order now.

    `priority` gives jobs another one.  It outlives a restart.  409 if one of them does not wait (any more): nothing is
    changed then.
    """
    return context.hardware.order(body)


@router.get("/platform/resonator", summary="What is in the clamping unit", responses=problems(*OWNER))
def get_mounted_resonator(context: Shared) -> MountedResonator:
    """The resonator that was last named, by this path or by a measurement."""
    return context.hardware.mounted()


@router.post(
    "/platform/resonator",
    summary="Say that a resonator was put into the clamping unit",
    responses=problems(409, 415, 422, 507, *OWNER),
)
def set_mounted_resonator(body: MountRequest, context: Shared) -> MountedResonator:
    """A schedule with several resonators in turn waits for it, where the platform does not change them by itself."""
    return context.hardware.set_mounted(body)


@router.get("/problems/{kind}", summary="What a kind of problem means", responses=problems(404))
def get_problem_kind(kind: Annotated[str, Path(examples=["sequence-rejected"])]) -> ProblemKind:
    """Title and meaning of the `type` of a problem details object."""
    kinds = problem_kinds()
    if kind not in kinds:
        raise UnknownId(f"no kind of problem is called {kind!r}", remedy=f"one of: {', '.join(sorted(kinds))}")
    meaning = (kinds[kind].__doc__ or "").strip()
    return ProblemKind(type=f"/problems/{kind}", title=kinds[kind].title, meaning=meaning)

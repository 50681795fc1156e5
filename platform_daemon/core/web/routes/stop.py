"""Stop and health: all that the stop port answers, and part of the main port."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import APIRouter, Request

from platform_daemon import __version__
from platform_daemon.core.schemas.stop import Health, StopReport
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.own_thread import run_in_own_thread
from platform_daemon.core.web.problems import problems

router = APIRouter(tags=["platform"], route_class=GuardedRoute)


@router.get("/health", summary="Is the daemon alive?")
def get_health() -> Health:
    """Answers as long as the process does."""
    return Health(status="ok", version=__version__)


@router.post("/stop", summary="All outputs off, now", responses=problems(502, 503, 504))
async def stop(request: Request) -> StopReport:
    """Amplifier off, card stopped, receiver disconnected, all acquisitions cancelled.  Shots already on disk stay.

    200 only where outputs were proved off.  A hardware process that does not answer for 2 s is ended, so that its guard
    switches off, and the answer waits for the next one to prove it; 503 if none has done so after 15 s.
    """
    outputs_off: Callable[[], StopReport] = request.app.state.outputs_off
    return await run_in_own_thread(outputs_off)

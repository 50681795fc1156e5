"""What the platform is and does: state, readiness, stop, the kinds of problems."""

from __future__ import annotations

from typing import Any

import anyio
from fastapi import APIRouter
from fastapi.responses import JSONResponse

from platform_daemon import __version__
from platform_daemon.engine import UnknownId
from platform_daemon.settings import load_sequence, load_specimen, shipped

from ..context import Shared
from ..models import ProblemModel, ResetModel
from ..problems import problem_kinds

router = APIRouter(tags=["platform"])


@router.get("/", summary="Where everything is")
def root() -> dict[str, Any]:
    """Entry points of the API."""
    paths = (
        "platform",
        "devices",
        "acquisitions",
        "calibrations",
        "recordings",
        "fits",
        "diagnoses",
        "models",
        "resonators",
        "health",
        "ready",
        "docs",
        "openapi.json",
    )
    return {"name": "platform-daemon", "version": __version__, "links": {p: f"/{p}" for p in paths}}


@router.get("/health", summary="Is the daemon alive?")
def health() -> dict[str, str]:
    """Answers as long as the process does."""
    return {"status": "ok", "version": __version__}


@router.get("/ready", summary="Is everything warmed up?")
def ready(context: Shared) -> JSONResponse:
    """200 once every part has warmed up, 503 before, naming the parts; requests are served all the same."""
    parts = {"platform": context.engine.warm, **context.warm}
    return JSONResponse({"ready": all(parts.values()), "warm": parts}, 200 if all(parts.values()) else 503)


@router.get("/platform", summary="State of every device, and the job that runs")
def platform(context: Shared) -> dict[str, Any]:
    """As last read back, at `read_at`: every second while idle, in the RX window of each shot of an acquisition."""
    return context.engine.status()


@router.get("/devices", summary="What is there: identity, state and last error of each device")
def devices(context: Shared) -> dict[str, Any]:
    """One entry per device, as last read back; one that does not answer is there with its error."""
    return {"devices": context.engine.devices()}


@router.get("/resonators", summary="Resonators that can be measured")
def resonators() -> dict[str, Any]:
    """Resonators by the name to use in an acquisition, with variant and the presets of their sequence."""
    found = {name: load_specimen(name)[0] for name in shipped("resonators")}
    presets = {s.variant: load_sequence(s.variant).model_dump() for s in found.values()}
    return {n: {"name": s.name, "variant": s.variant, "sequence": presets[s.variant]} for n, s in found.items()}


@router.post("/stop", summary="All outputs off, now")
async def stop(context: Shared) -> dict[str, str]:
    """Amplifier off, card stopped, receiver disconnected, all acquisitions cancelled.  Shots already on disk stay."""
    # Threads of its own: downloads and other long requests must not make it wait.
    await anyio.to_thread.run_sync(context.engine.outputs_off, limiter=anyio.CapacityLimiter(1))
    return {"status": "outputs are off, acquisitions are cancelled"}


@router.post(
    "/devices/power_amplifier/reset",
    summary="Clear the amplifier's latched fault after a trip",
    response_model=ResetModel,
    responses={409: {"model": ProblemModel}, 502: {"model": ProblemModel}},
)
def reset_amplifier(context: Shared) -> dict[str, Any]:
    """Find the cause of the trip first.

    Puts no power out: the amplifier is disabled and muted afterwards, and the next series begins with its self-test.
    409 while a series or a calibration runs; 502 if the fault stays, because its cause persists or the amplifier has
    no reset command.  Without a fault there is nothing to clear: `fault` is null.
    """
    return context.engine.reset_fault()


@router.get("/problems/{kind}", summary="What a kind of problem means")
def problem_page(kind: str) -> dict[str, str]:
    """Title and meaning of the `type` of a problem details object."""
    kinds = problem_kinds()
    if kind not in kinds:
        raise UnknownId(f"no kind of problem is called {kind!r}", remedy=f"one of: {', '.join(sorted(kinds))}")
    return {"type": f"/problems/{kind}", "title": kinds[kind].title, "meaning": (kinds[kind].__doc__ or "").strip()}

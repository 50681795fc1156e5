"""The FastAPI application."""

from __future__ import annotations

from collections.abc import Iterator

from fastapi import APIRouter, FastAPI
from fastapi_offline import FastAPIOffline

from platform_daemon import __version__
from platform_daemon.core.registry import features

from . import problems
from .context import Context
from .guarded import guard, include
from .job_routes import standard_router
from .network.policy import Network
from .openapi import complete_schema, serve_schema
from .routes import catalogue, changes, events, jobs, platform, stop

DESCRIPTION = """Runs the 3D Helmholtz-coil platform that reads magneto-mechanical resonators.
Long work is a job: POST answers 202 with a Location, GET it for progress and result, DELETE it to cancel.
Errors are RFC 9457 problem details with a remedy.  Every key names the unit of its value: SI, or what people set."""

_TAGS = {
    "platform": "State of the hardware, outputs off, and what problems mean",
    "catalogue": "Resonators and sequences that have a name",
    "events": "What happens, as it happens",
    "jobs": "Jobs of all kinds in one list",
    "derived": "What follows from fits, recordings and plans",
}


def create_api(context: Context, network: Network | None = None, root_path: str = "") -> FastAPI:
    """The application over a context; network: its rules, None: those of loopback without tokens; root_path: below
    which a proxy serves it, as /mmr.

    Raises RuntimeError for a route that the table of access does not know.
    """
    tags = {**_TAGS, **dict(each.tag for each in features() if each.tag is not None)}
    # Labs without internet must see the documentation page too: its scripts come from here, not from a CDN.
    app = FastAPIOffline(
        title="platform-daemon",
        version=__version__,
        description=DESCRIPTION,
        openapi_tags=[{"name": name, "description": text} for name, text in tags.items()],
        generate_unique_id_function=lambda route: route.name,
        separate_input_output_schemas=False,
        responses=problems.problems(500),
        servers=[{"url": root_path}] if root_path else None,
    )
    app.root_path = root_path
    guard(app, network or Network(), context.hardware.outputs_off)
    app.state.context = context
    for router in (
        stop.router,
        platform.router,
        catalogue.router,
        events.router,
        jobs.router,
        changes.router,
        *feature_routers(),
    ):
        include(app, router)
    complete_schema(app)
    serve_schema(app)
    return app


def feature_routers() -> Iterator[APIRouter]:
    """The routers of all features, in the order of the registry."""
    for feature in features():
        yield from (feature.load(module).router for module in feature.routes)
        if feature.job is not None and not feature.routes:
            yield standard_router(feature.kind.name)

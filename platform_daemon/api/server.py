"""The FastAPI application, and the one that can do nothing but stop."""

from __future__ import annotations

from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from fastapi_offline import FastAPIOffline

from platform_daemon import __version__

from . import problems
from .context import Context
from .network.front import Front
from .network.lanes import Lanes
from .network.policy import Network
from .network.routes import refuse_unguarded
from .openapi import complete_schema, serve_schema
from .routes import (
    acquisitions,
    alarms,
    calibrations,
    catalogue,
    characterisations,
    derived,
    design,
    diagnoses,
    events,
    fits,
    models,
    platform,
    procedures,
    recordings,
    schedules,
    self_tests,
    specimens,
)

DESCRIPTION = """Runs the 3D Helmholtz-coil platform that reads magneto-mechanical resonators.
Long work is a job: POST answers 202 with a Location, GET it for progress and result, DELETE it to cancel.
Errors are RFC 9457 problem details with a remedy.  Every key names the unit of its value: SI, or what people set."""

TAGS = {
    "platform": "State of the hardware, outputs off, and what problems mean",
    "catalogue": "Resonators and sequences that have a name",
    "acquisitions": "Series of shots",
    "procedures": "Several steps, each a series, in one recording: sweeps",
    "events": "What happens, as it happens",
    "alarms": "What somebody should know, and numbers for Prometheus",
    "schedules": "Work by the calendar, and what became of each start",
    "calibrations": "Of the receive and of the transmit side",
    "self-tests": "Is the chain as the platform file says?",
    "recordings": "What was measured, with its dm/dt",
    "specimens": "What specimens do over months",
    "fits": "Of stored recordings",
    "derived": "What follows from fits, recordings and plans",
    "design": "What magnets and bearing alone say of a resonator, and manufacturing defects",
    "diagnoses": "What the declared model lacks",
    "characterisations": "The tables of the paper, from many shots of one resonator",
    "models": "Declared models, and those that were adopted from diagnoses",
}


def create_api(context: Context, network: Network | None = None) -> FastAPI:
    """The application over a context; network: its rules, None: those of loopback without tokens.

    Raises RuntimeError for a route that the table of access does not know.
    """
    # Labs without internet must see the documentation page too: its scripts come from here, not from a CDN.
    app = FastAPIOffline(
        title="platform-daemon",
        version=__version__,
        description=DESCRIPTION,
        openapi_tags=[{"name": name, "description": text} for name, text in TAGS.items()],
        generate_unique_id_function=lambda route: route.name,
        separate_input_output_schemas=False,
        responses=problems.problems(500),
    )
    _guard(app, context, network or Network())
    for routes in (
        platform,
        catalogue,
        acquisitions,
        procedures,
        schedules,
        events,
        alarms,
        calibrations,
        self_tests,
        recordings,
        specimens,
        fits,
        derived,
        design,
        diagnoses,
        characterisations,
        models,
    ):
        _include(app, routes.router)
    complete_schema(app)
    serve_schema(app)
    return app


def create_stop_api(context: Context, network: Network) -> FastAPI:
    """An application that can do nothing but stop, by the same rules, and say that it is there."""
    app = FastAPI(title="platform-daemon", openapi_url=None, docs_url=None, redoc_url=None)
    _guard(app, context, network)
    only = APIRouter(routes=[r for r in platform.router.routes if getattr(r, "name", "") in ("stop", "get_health")])
    _include(app, only)
    return app


def _guard(app: FastAPI, context: Context, network: Network) -> None:
    """Give an application what its routes need, problems as answers, and the layer in front."""
    app.state.context, app.state.network, app.state.lanes = context, network, Lanes(network.limits)
    app.state.methods = {}
    problems.install(app)
    app.add_middleware(Front, network=network, respond=problems.respond)


def _include(app: FastAPI, router: APIRouter) -> None:
    refuse_unguarded(router.routes)
    for route in router.routes:
        if isinstance(route, APIRoute):
            app.state.methods.setdefault(route.path, set()).update(route.methods)
    app.include_router(router)

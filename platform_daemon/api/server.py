"""The FastAPI application."""

from __future__ import annotations

from fastapi import FastAPI
from fastapi_offline import FastAPIOffline

from platform_daemon import __version__

from . import problems
from .context import Context
from .guarded import guard, include
from .network.policy import Network
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
    stop,
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
    guard(app, network or Network(), context.hardware.outputs_off)
    app.state.context = context
    for routes in (
        stop,
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
        include(app, routes.router)
    complete_schema(app)
    serve_schema(app)
    return app

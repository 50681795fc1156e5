"""The FastAPI application, and a uvicorn server whose first act on a signal is to switch outputs off."""

from __future__ import annotations

from types import FrameType

import uvicorn
from fastapi import FastAPI
from fastapi_offline import FastAPIOffline

from platform_daemon import __version__
from platform_daemon.engine import Engine

from . import problems
from .context import Context
from .openapi import complete_schema
from .routes import (
    acquisitions,
    calibrations,
    catalogue,
    characterisations,
    derived,
    design,
    diagnoses,
    fits,
    models,
    platform,
    procedures,
    recordings,
)

DESCRIPTION = """Runs the 3D Helmholtz-coil platform that reads magneto-mechanical resonators.
Long work is a job: POST answers 202 with a Location, GET it for progress and result, DELETE it to cancel.
Errors are RFC 9457 problem details with a remedy.  Every key names the unit of its value: SI, or what people set."""

TAGS = {
    "platform": "State of the hardware, outputs off, and what problems mean",
    "catalogue": "Resonators and sequences that have a name",
    "acquisitions": "Series of shots",
    "procedures": "Several steps, each a series, in one recording: sweeps",
    "calibrations": "Of the receive and of the transmit side",
    "recordings": "What was measured, with its dm/dt",
    "fits": "Of stored recordings",
    "derived": "What follows from fits, recordings and plans",
    "design": "What magnets and bearing alone say of a resonator, and manufacturing defects",
    "diagnoses": "What the declared model lacks",
    "characterisations": "The tables of the paper, from many shots of one resonator",
    "models": "Declared models, and those that were adopted from diagnoses",
}


def create_api(context: Context) -> FastAPI:
    """The application over an engine and its folders."""
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
    app.state.context = context
    problems.install(app)
    for routes in (
        platform,
        catalogue,
        acquisitions,
        procedures,
        calibrations,
        recordings,
        fits,
        derived,
        design,
        diagnoses,
        characterisations,
        models,
    ):
        app.include_router(routes.router)
    complete_schema(app)
    return app


class Server(uvicorn.Server):
    """Outputs off comes first in the signal path: uvicorn's own shutdown can wait for clients that never leave."""

    def __init__(self, app: FastAPI, engine: Engine, host: str, port: int) -> None:
        super().__init__(
            uvicorn.Config(app, host=host, port=port, log_config=None, timeout_graceful_shutdown=3, access_log=False)
        )
        self._engine = engine

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Outputs off, then uvicorn's orderly end."""
        try:
            self._engine.outputs_off()
        finally:
            super().handle_exit(sig, frame)

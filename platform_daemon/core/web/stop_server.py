"""The application of the stop port.  Its process loads this and little else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware

from platform_daemon.core.schemas.stop import StopReport

from .guarded import guard, include
from .network.origins import page_origins
from .network.policy import Network
from .routes import stop


def create_stop_api(outputs_off: Callable[[], StopReport], network: Network) -> FastAPI:
    """An application with stop and health only, and the same rules as the main one.

    The operator's page comes from the main port, which is another origin for a browser: it may stop as well.
    """
    app = FastAPI(title="platform-daemon", openapi_url=None, docs_url=None, redoc_url=None)
    pages = page_origins(network.names, network.port)
    guard(app, replace(network, page_origins=pages), outputs_off)
    include(app, stop.router)
    app.add_middleware(
        CORSMiddleware,
        allow_origins=sorted(pages),
        allow_methods=["POST"],
        allow_headers=["Authorization", "Content-Type"],
    )
    return app

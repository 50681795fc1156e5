"""The application that can do nothing but stop.  Its process loads this and little else."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import FastAPI

from platform_daemon.schemas import StopReport

from .guarded import guard, include
from .network.policy import Network
from .routes import stop


def create_stop_api(outputs_off: Callable[[], StopReport], network: Network) -> FastAPI:
    """An application that can do nothing but stop, by the same rules as the other, and say that it is there."""
    app = FastAPI(title="platform-daemon", openapi_url=None, docs_url=None, redoc_url=None)
    guard(app, network, outputs_off)
    include(app, stop.router)
    return app

"""What every application of ours has: rules, problems as answers, guarded routes."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute

from platform_daemon.schemas import StopReport

from . import problems
from .network.front import Front
from .network.lanes import Lanes
from .network.policy import Network
from .network.routes import refuse_unguarded


def guard(app: FastAPI, network: Network, outputs_off: Callable[[], StopReport]) -> None:
    """Give an application what its routes need, problems as answers, and the layer in front."""
    app.state.network, app.state.lanes, app.state.outputs_off = network, Lanes(network.limits), outputs_off
    app.state.methods = {}
    problems.install(app)
    app.add_middleware(Front, network=network, respond=problems.respond)


def include(app: FastAPI, router: APIRouter) -> None:
    """Serve these routes.  Raises RuntimeError for one that is not guarded."""
    refuse_unguarded(router.routes)
    for route in router.routes:
        if isinstance(route, APIRoute):
            app.state.methods.setdefault(route.path, set()).update(route.methods)
    app.include_router(router)

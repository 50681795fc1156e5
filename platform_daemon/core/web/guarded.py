"""What the main application and the stop application have in common: rules, problem details, guarded routes."""

from __future__ import annotations

import copy
from collections.abc import Callable

from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from fastapi.sse import EventSourceResponse

from platform_daemon.core.schemas.stop import StopReport

from . import problems
from .network.concurrency import ConcurrencyLimits
from .network.middleware import AdmissionMiddleware
from .network.policy import Network
from .network.routes import GuardedRoute, refuse_unguarded


def guard(app: FastAPI, network: Network, outputs_off: Callable[[], StopReport]) -> None:
    """Give an application what its routes need, problem details as answers to errors, and the admission middleware."""
    app.state.network = network
    app.state.concurrency = ConcurrencyLimits(network.limits)
    app.state.outputs_off = outputs_off
    app.state.methods = {}
    problems.install(app)
    app.add_middleware(AdmissionMiddleware, network=network, respond=problems.respond)


def include(app: FastAPI, router: APIRouter) -> None:
    """Serve these routes, with HEAD wherever there is GET.  Raises RuntimeError for one that is not guarded."""
    refuse_unguarded(router.routes)
    heads = APIRouter(route_class=GuardedRoute)
    heads.routes += [_head(route) for route in router.routes if isinstance(route, APIRoute) and _has_head(route)]
    for route in (*router.routes, *heads.routes):
        if isinstance(route, APIRoute):
            app.state.methods.setdefault(route.path, set()).update(route.methods)
    app.include_router(router)
    app.include_router(heads)


def _has_head(route: APIRoute) -> bool:
    """HEAD describes a GET that has an end (RFC 9110, 9.3.2), which a stream of events has not."""
    return "GET" in (route.methods or ()) and route.response_class is not EventSourceResponse


def _head(route: APIRoute) -> APIRoute:
    """The same route for HEAD, by the same name in the table of access; the server leaves the body out.

    It is not in the schema: a client generator would make every function twice, under one name.
    """
    twin = copy.copy(route)
    twin.methods, twin.include_in_schema = {"HEAD"}, False
    return twin

"""Serves the files of the operator's page."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import JSONResponse
from starlette.datastructures import Headers

from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.schemas import parameters
from platform_daemon.core.web.network.origins import host_of
from platform_daemon.core.web.network.policy import Network
from platform_daemon.core.web.network.routes import GuardedRoute

from .files import INDEX, StaticFile, read_static_file

PARAMETERS = "parameters.json"
"""Symbols and units of all parameters, as they are defined once, in Python."""
Wall = Annotated[str, Query(max_length=10, description="the page is for a wall; its script reads this")]
router = APIRouter(prefix="/page", route_class=GuardedRoute)


@router.get("/{path:path}", name="get_page_file", include_in_schema=False)
def get_page_file(path: str, request: Request, wall: Wall = "") -> Response:
    """A file of the page; "" is the page itself.  It needs no token, since it holds no data.

    Raises UnknownId for what is no file of the page, or is not installed.
    """
    if path == PARAMETERS:
        return JSONResponse({name: asdict(each) for name, each in parameters.PARAMETERS.items()})
    network: Network = request.app.state.network
    found = read_static_file(path or INDEX, network.port, network.stop_port)
    if found is None:
        remedy = "open /page/; what stands below vendor/ is installed by `make install`"
        raise UnknownId(f"the page has no file {path[:100]!r}", where="path", remedy=remedy)
    return _answer(found, request)


def _answer(found: StaticFile, request: Request) -> Response:
    headers = {
        "ETag": found.etag,
        "Cache-Control": "no-cache",  # kept by the browser, and asked for again by its ETag
        "Vary": "Accept-Encoding",
        "Content-Security-Policy": content_security_policy(request),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
    }
    if found.etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    if "gzip" in request.headers.get("accept-encoding", ""):
        return Response(found.compressed, media_type=found.media_type, headers={**headers, "Content-Encoding": "gzip"})
    return Response(found.content, media_type=found.media_type, headers=headers)


def content_security_policy(request: Request) -> str:
    """Nothing from elsewhere, but requests to the stop port of this host, which is another origin."""
    network: Network = request.app.state.network
    host = host_of(Headers(scope=request.scope).get("host", ""))
    stop = f" {request.url.scheme}://{host}:{network.stop_port}" if network.stop_port and ":" not in host else ""
    return f"default-src 'self'; connect-src 'self'{stop}; img-src 'self' blob:; frame-ancestors 'none'"

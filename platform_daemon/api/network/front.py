"""The outermost layer of an application: names of the host, who asks, how often.  No route has been looked for yet."""

from __future__ import annotations

from collections.abc import Callable

import anyio
from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from drivers.errors import PlatformError

from .origins import check_host
from .policy import Network
from .rate import Rate

Respond = Callable[[PlatformError, str], Response]
NEVER_COUNTED = "/stop"  # it must be answered however often somebody asks


class Front:
    """An ASGI application around another one; respond: makes the answer of an error, for a path."""

    def __init__(self, app: ASGIApp, network: Network, respond: Respond) -> None:
        self._app, self._network, self._respond = app, network, respond
        self._rate = Rate(network.limits.requests_per_s, network.limits.burst)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on with who asks."""
        if scope["type"] == "http":
            try:
                self._look_at(scope)
            except PlatformError as error:
                await self._respond(error, scope["path"])(scope, receive, send)
                return
        try:
            await self._app(scope, receive, send)
        except* anyio.BrokenResourceError:
            pass  # of FastAPI's stream of events: its client has left in the middle of one

    def _look_at(self, scope: Scope) -> None:
        """Keep who asks.  Raises ForeignHost, TooManyRequests."""
        headers = Headers(scope=scope)
        check_host(headers, self._network.names)
        address = scope["client"][0] if scope.get("client") else ""
        caller = self._network.gate.caller(headers, address)
        if scope["path"] != NEVER_COUNTED:
            self._rate.count(caller.client)
        scope.setdefault("state", {})["caller"] = caller

"""The outermost layer of an application: length of the body, host, caller, rate; before a route is matched."""

from __future__ import annotations

import math
import time
from collections import OrderedDict
from collections.abc import Callable

import anyio
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from drivers.errors import PlatformError

from .origins import check_host
from .policy import Network
from .refusals import AmbiguousLength, TooManyRequests

ErrorResponse = Callable[[PlatformError, str], Response]
"""Makes the answer of an error to a request for a path."""
MAX_CLIENTS = 4096  # that are remembered; beyond, those whose last request is oldest are dropped
_NOT_RATE_LIMITED = "/stop"  # it must be answered however often it is requested


class AdmissionMiddleware:
    """ASGI middleware that refuses a request before any route is looked for, or adds the caller to its state.

    respond: makes the answer of a refusal.
    """

    def __init__(self, app: ASGIApp, network: Network, respond: ErrorResponse) -> None:
        self._app = app
        self._network = network
        self._respond = respond
        self._rate = RateLimiter(network.limits.requests_per_s, network.limits.burst)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on with its caller."""
        if scope["type"] == "http":
            try:
                self._admit(scope)
            except PlatformError as error:
                await self._respond(error, scope["path"])(scope, receive, send)
                return
            send = _with_own_paths(send, scope)
        try:
            await self._app(scope, receive, send)
        except* anyio.BrokenResourceError:
            pass  # of FastAPI's stream of events: its client has left in the middle of one

    def _admit(self, scope: Scope) -> None:
        """Raises AmbiguousLength, ForeignHost, TooManyRequests."""
        headers = Headers(scope=scope)
        _check_length(headers, scope["http_version"])
        check_host(headers, self._network.names)
        address = scope["client"][0] if scope.get("client") else ""
        caller = self._network.authenticator.caller(headers, address)
        if scope["path"].removeprefix(scope.get("root_path", "")) != _NOT_RATE_LIMITED:
            self._rate.count(caller.client)
        scope.setdefault("state", {})["caller"] = caller


def _with_own_paths(send: Send, scope: Scope) -> Send:
    """Let the headers Location and Link name paths of this server, below its root path, without scheme and host.

    A redirect of Starlette names the scheme that the request came with: behind a proxy that speaks TLS, http.  The
    client knows better (RFC 9110, 10.2.2), and no header of the request needs to be believed.
    """
    root: str = scope.get("root_path", "")
    here = tuple(f"{scheme}://{Headers(scope=scope).get('host', '')}" for scheme in ("http", "https"))

    def relocated(value: str) -> str:
        begin = "<" if value.startswith("<") else ""
        path = value.removeprefix(begin)
        for each in here:
            path = path.removeprefix(each)
        below = not path.startswith("/") or path.startswith("//") or not root or path.startswith(f"{root}/")
        return f"{begin}{path}" if below else f"{begin}{root}{path}"

    async def send_relocated(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name in ("location", "link"):
                if name in headers:
                    headers[name] = relocated(headers[name])
        await send(message)

    return send_relocated


def _check_length(headers: Headers, http_version: str) -> None:
    """h11 accepts Transfer-Encoding together with Content-Length (RFC 9112, 6.3), but a proxy in front may take the
    other one, and see one request where h11 sees two.  HTTP/1.0 knows no Transfer-Encoding (6.1).

    Raises AmbiguousLength, whose answer closes the connection.
    """
    if "transfer-encoding" in headers and ("content-length" in headers or http_version == "1.0"):
        raise AmbiguousLength(
            "the request says with Transfer-Encoding and otherwise how long its body is",
            where="Transfer-Encoding",
            why="two readers could take it for two different requests",
            remedy="send Content-Length, or Transfer-Encoding: chunked of HTTP/1.1, and not both",
        )


class RateLimiter:
    """A token bucket per client: `burst` requests at once, and `per_s` a second on average.  For one thread."""

    def __init__(self, per_s: float, burst: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_s = per_s
        self._burst = burst
        self._clock = clock
        self._empty_at: OrderedDict[str, float] = OrderedDict()  # when the bucket will have run empty

    def count(self, client: str) -> None:
        """Count a request of a client.  Raises TooManyRequests with the seconds to wait."""
        now = self._clock()
        due = max(self._empty_at.pop(client, now), now) + 1 / self._per_s
        late = due - now - self._burst / self._per_s
        self._empty_at[client] = due if late <= 0 else due - 1 / self._per_s
        while len(self._empty_at) > MAX_CLIENTS:
            self._empty_at.popitem(last=False)
        if late > 0:
            what = f"this client asks more often than {self._per_s:g} times a second"
            remedy = "ask less often: a job's progress changes with its shots, the platform's state every second"
            raise TooManyRequests(what, wait_s=max(1, math.ceil(late)), remedy=remedy)

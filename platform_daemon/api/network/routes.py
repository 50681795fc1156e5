"""The class of all routes: token, role, origin, content type and body are looked at before anything else."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Coroutine, Iterable
from contextlib import AsyncExitStack
from typing import Any

from fastapi.routing import APIRoute
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import BaseRoute
from starlette.types import Receive, Scope, Send

from drivers.errors import PlatformError

from .access import ACCESS, Access, Takes
from .auditing import Auditor
from .body import read_body, with_body
from .callers import Caller
from .lanes import Lanes
from .origins import HARMLESS, check_origin
from .policy import Network
from .query import check_query, query_keys
from .refusals import RoleTooLow, Unauthenticated, UnsupportedMediaType

Handler = Callable[[Request], Coroutine[Any, Any, Response]]
STOP = "stop"
_kept: set[asyncio.Task[None]] = set()  # the loop itself holds tasks only weakly


class GuardedRoute(APIRoute):
    """A route that asks the table of access first.  It stands around the handler, behind which the body is parsed."""

    def get_route_handler(self) -> Handler:
        """The handler of FastAPI behind the guard."""
        handler, name, keys = super().get_route_handler(), self.name, query_keys(self)

        async def guarded(request: Request) -> Response:
            return await _answer(request, name, ACCESS[name], handler, keys)

        return guarded


def refuse_unguarded(routes: Iterable[BaseRoute]) -> None:
    """Raises RuntimeError for a route that the table of access does not know, or that does not ask it."""
    for route in routes:
        name = getattr(route, "name", str(route))
        if not isinstance(route, GuardedRoute):
            raise RuntimeError(f"route {name} is not guarded: make its router with route_class=GuardedRoute")
        if name not in ACCESS:
            raise RuntimeError(f"route {name} is not in the table of access: say there who may use it")


def may_still(request: Request) -> bool:
    """Would it be let in if it came now?  For answers that take long."""
    network: Network = request.app.state.network
    caller = network.gate.caller(request.headers, request.state.caller.address)
    try:
        caller.must_be(ACCESS[request.scope["route"].name].role)
    except (Unauthenticated, RoleTooLow):
        return False
    return True


async def _answer(request: Request, name: str, access: Access, handler: Handler, keys: Collection[str]) -> Response:
    """Raises what the guard and the handler do."""
    network: Network = request.app.state.network
    caller: Caller = request.state.caller
    caller.must_be(access.role)
    check_origin(request.method, request.headers)
    if name != STOP:  # nothing that it might have misspelt is worth waiting for
        check_query(request.query_params, keys)
    _check_content_type(request, name)
    try:
        body = await read_body(request, network.limits)
    except ClientDisconnect:
        return Response(status_code=400)  # nobody is there to read it
    lanes: Lanes = request.app.state.lanes
    auditor = Auditor(network.audit if access.audited else None, caller, name, request, body)
    async with AsyncExitStack() as held:
        await held.enter_async_context(lanes.for_answer(access.takes))
        async with lanes.for_work(access.takes):
            try:
                response = await handler(with_body(request, body))
            except PlatformError as error:
                await _written(name, auditor.failed(error))
                raise
        await _written(name, auditor.done(response.status_code))
        return response if access.takes is not Takes.DOWNLOAD else _Held(response, held.pop_all())


async def _written(name: str, line: Coroutine[Any, Any, None]) -> None:
    """Write a line of the audit log before the answer leaves; of stop meanwhile: no slow disk may hold that up."""
    if name != STOP:
        await line
        return
    task = asyncio.create_task(line)
    _kept.add(task)
    task.add_done_callback(_kept.discard)


def _check_content_type(request: Request, name: str) -> None:
    """Raises UnsupportedMediaType for what may change something and is not JSON.

    A page of a browser cannot send that to another server unasked.  Two may leave it out if they have no body: DELETE,
    for which a page has to ask first, which nobody answers, and which clients send without; and `POST /stop`, since
    whoever types that is in a hurry.
    """
    said = request.headers.get("content-type")
    if request.method in HARMLESS or _is_json(said):
        return
    has_body = request.headers.get("content-length", "0") != "0" or "transfer-encoding" in request.headers
    if (request.method == "DELETE" or name == STOP) and said is None and not has_body:
        return
    what = f"the body is sent as {said}" if said else "the request does not say what its body is"
    why = "only JSON is taken, and only if the request says that it is"
    remedy = "add the header, with curl: -H 'Content-Type: application/json'"
    raise UnsupportedMediaType(what, where="Content-Type", why=why, remedy=remedy)


def _is_json(said: str | None) -> bool:
    kind = (said or "").partition(";")[0].strip().lower()
    return kind == "application/json" or (kind.startswith("application/") and kind.endswith("+json"))


class _Held(Response):
    """An answer that holds its place in a lane until it has left, or its client has."""

    def __init__(self, answer: Response, held: AsyncExitStack) -> None:
        super().__init__(status_code=answer.status_code)
        self._answer, self._held = answer, held

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async with self._held:
            await self._answer(scope, receive, send)

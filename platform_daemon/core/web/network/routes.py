"""The class of all routes: it checks token, role, origin, content type and body before the handler runs."""

from __future__ import annotations

import asyncio
import difflib
from collections.abc import Callable, Coroutine, Iterable, Mapping
from contextlib import AsyncExitStack
from typing import Any

from fastapi import params
from fastapi.dependencies.utils import field_annotation_is_sequence, get_flat_params
from fastapi.routing import APIRoute
from starlette.datastructures import QueryParams
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import BaseRoute
from starlette.types import Receive, Scope, Send

from drivers.errors import InputError, PlatformError

from .access import Access, Takes, access_of, required_access
from .auditing import Auditor
from .body import read_body, refuse_repeated_keys, with_body
from .callers import Caller
from .concurrency import ConcurrencyLimits
from .origins import SAFE_METHODS, check_origin
from .policy import Network
from .refusals import RoleTooLow, Unauthenticated, UnsupportedMediaType

Handler = Callable[[Request], Coroutine[Any, Any, Response]]
STOP = "stop"
_background: set[asyncio.Task[None]] = set()  # the loop itself holds tasks only weakly


class GuardedRoute(APIRoute):
    """A route that consults the table of roles first; the check runs before the body is parsed."""

    def get_route_handler(self) -> Handler:
        """The handler of FastAPI, wrapped in the checks."""
        handler, name, keys = super().get_route_handler(), self.name, query_keys(self)

        async def guarded(request: Request) -> Response:
            return await _answer(request, name, required_access(name), handler, keys)

        return guarded


def refuse_unguarded(routes: Iterable[BaseRoute]) -> None:
    """Raises RuntimeError for a route that is not in the table of roles, or does not consult it."""
    for route in routes:
        name = getattr(route, "name", str(route))
        if not isinstance(route, GuardedRoute):
            raise RuntimeError(f"route {name} is not guarded: make its router with route_class=GuardedRoute")
        if access_of(name) is None:
            raise RuntimeError(f"route {name} is not in the table of access: add it with its role")


def may_still(request: Request) -> bool:
    """Would the request be accepted if it came now?  For streams, which last long."""
    network: Network = request.app.state.network
    caller = network.authenticator.caller(request.headers, request.state.caller.address)
    try:
        caller.must_be(required_access(request.scope["route"].name).role)
    except (Unauthenticated, RoleTooLow):
        return False
    return True


async def _answer(request: Request, name: str, access: Access, handler: Handler, keys: Mapping[str, bool]) -> Response:
    """Check a request and answer it.  Raises what the checks and the handler raise.

    A slot for work is free again once the handler has returned, one for a download only once the response is sent.
    """
    network: Network = request.app.state.network
    caller: Caller = request.state.caller
    caller.must_be(access.role)
    check_origin(request.method, request.headers, network.page_origins)
    if name != STOP:  # a misspelt key must not keep outputs on
        check_query(request.query_params, keys)
    _check_content_type(request, name)
    try:
        body = await read_body(request, network.limits)
    except ClientDisconnect:
        return Response(status_code=400)  # the client has left
    if name != STOP:
        refuse_repeated_keys(body)
    concurrency: ConcurrencyLimits = request.app.state.concurrency
    auditor = Auditor(network.audit if access.audited else None, caller, name, request, body)
    async with AsyncExitStack() as until_sent:
        await until_sent.enter_async_context(concurrency.for_answer(access.takes))
        async with concurrency.for_work(access.takes):
            try:
                response = await handler(with_body(request, body))
            except PlatformError as error:
                await _record(name, auditor.failed(error))
                raise
        await _record(name, auditor.done(response.status_code))
        return response if access.takes is not Takes.DOWNLOAD else _HeldResponse(response, until_sent.pop_all())


def query_keys(route: APIRoute) -> dict[str, bool]:
    """The keys that a route and its dependencies take; True: it may be given several times, which makes a list."""
    keys = [f for f in get_flat_params(route.dependant) if isinstance(f.field_info, params.Query)]
    return {f.alias: field_annotation_is_sequence(f.field_info.annotation) for f in keys}


def check_query(query: QueryParams, known: Mapping[str, bool]) -> None:
    """Raises InputError for the first unknown key, and for one that is given twice but takes one value."""
    unknown = next((key for key in query if key not in known), None)
    if unknown is None:
        _refuse_second_value(query, known)
        return
    near = difflib.get_close_matches(unknown, known, 1)
    there = f"this path takes {', '.join(sorted(known))}" if known else "this path takes none"
    remedy = f"say {near[0]}" if near else "leave it out; /docs shows what each path takes"
    raise InputError(f"no key of the query is called {unknown[:100]!r}", where="query", why=there, remedy=remedy)


def _refuse_second_value(query: QueryParams, known: Mapping[str, bool]) -> None:
    for key in query:
        values = query.getlist(key)
        if len(values) > 1 and not known[key]:
            why = f"{' and '.join(repr(value[:40]) for value in values[:2])}: only one of them would count"
            raise InputError("a key of the query is given twice", where=key, why=why, remedy="give it once")


async def _record(name: str, line: Coroutine[Any, Any, None]) -> None:
    """Write a line of the audit log before the answer is sent; for stop meanwhile, as a slow disk must not delay it."""
    if name != STOP:
        await line
        return
    task = asyncio.create_task(line)
    _background.add(task)
    task.add_done_callback(_background.discard)


def _check_content_type(request: Request, name: str) -> None:
    """Raises UnsupportedMediaType for a request that may change something and is not JSON.

    A foreign page cannot send JSON without a preflight request, which this server does not answer.  Without a body two
    requests need no content type: DELETE, which always needs a preflight and which clients send without one, and
    `POST /stop`, which is typed in a hurry.
    """
    content_type = request.headers.get("content-type")
    if request.method in SAFE_METHODS or _is_json(content_type):
        return
    has_body = request.headers.get("content-length", "0") != "0" or "transfer-encoding" in request.headers
    if (request.method == "DELETE" or name == STOP) and content_type is None and not has_body:
        return
    what = f"the body is sent as {content_type}" if content_type else "the request does not say what its body is"
    why = "only JSON is taken, and only if the request says that it is"
    remedy = "add the header, with curl: -H 'Content-Type: application/json'"
    raise UnsupportedMediaType(what, where="Content-Type", why=why, remedy=remedy)


def _is_json(content_type: str | None) -> bool:
    kind = (content_type or "").partition(";")[0].strip().lower()
    return kind == "application/json" or (kind.startswith("application/") and kind.endswith("+json"))


class _HeldResponse(Response):
    """A response that keeps resources until it has been sent, or its client has left."""

    def __init__(self, answer: Response, held: AsyncExitStack) -> None:
        super().__init__(status_code=answer.status_code)
        self._answer = answer
        self._held = held

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async with self._held:
            await self._answer(scope, receive, send)

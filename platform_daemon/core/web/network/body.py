"""Reads the body of a request within the limits of its length and of its time."""

from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

from starlette.requests import Request
from starlette.types import Message

from drivers.errors import InputError

from .limits import Limits
from .refusals import BodyTooLarge, BodyTooSlow


async def read_body(request: Request, limits: Limits) -> bytes:
    """The whole body of a request.

    Raises BodyTooLarge, before anything is read where the request says how long it is; BodyTooSlow; ClientDisconnect.
    """
    declared = request.headers.get("content-length", "0")
    if declared.isdigit() and int(declared) > limits.body_bytes:
        raise _too_large(f"{int(declared)} bytes", limits)
    parts, size = [], 0
    try:
        async with asyncio.timeout(limits.body_s):
            async for part in request.stream():
                size += len(part)
                if size > limits.body_bytes:
                    raise _too_large(f"more than {limits.body_bytes} bytes", limits)
                parts.append(part)
    except TimeoutError:
        what = f"after {limits.body_s:g} s only {size} bytes of the body had come"
        raise BodyTooSlow(what, where="body", remedy="send it at once") from None
    return b"".join(parts)


def refuse_repeated_keys(body: bytes) -> None:
    """Raises InputError for a table with a key twice, of which the last value would be taken in silence.

    What is no JSON is left to whoever reads it.
    """
    with contextlib.suppress(ValueError, RecursionError):
        _DECODER.decode(body.decode("utf-8-sig"))


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        what, remedy = f"the key {twice[:100]!r} is there twice", "say it once, with the value that is meant"
        raise InputError(what, where="body", remedy=remedy)
    return made


_DECODER = json.JSONDecoder(object_pairs_hook=_once)


def with_body(request: Request, body: bytes) -> Request:
    """The same request with its body, as if it had not been read yet."""
    sent = False

    async def receive() -> Message:
        nonlocal sent
        if sent:
            return await request.receive()
        sent = True
        return {"type": "http.request", "body": body, "more_body": False}

    return Request(request.scope, receive)


def _too_large(what: str, limits: Limits) -> BodyTooLarge:
    why = f"at most {limits.body_bytes} are taken"
    remedy = "no request needs so much: send fewer values, or ask in several requests"
    return BodyTooLarge(f"the body has {what}", where="body", why=why, remedy=remedy)

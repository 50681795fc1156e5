"""Messages between the process that owns the hardware and the others, over the local socket."""

from __future__ import annotations

from typing import Any

from .base import Schema


class RpcCall(Schema):
    """A call of a method: one line on the socket."""

    method: str
    """Name of the method."""
    arguments: tuple[Any, ...]
    """Its arguments: objects where it is sent, JSON where it was read."""


class RpcError(Schema):
    """An error as an answer to the calling process."""

    kinds: tuple[str, ...]
    """Name of its class, then of those that it comes from."""
    title: str
    """Kind of error in words."""
    what: str
    """What happened."""
    where: str
    """File, key, device or field."""
    why: str
    """Why."""
    remedy: str
    """What to do about it."""


class RpcAnswer(Schema):
    """The answer to one call: one line on the socket."""

    value: Any
    """What it brought: an object where it is sent, JSON where it was read; null where there is an error."""
    error: RpcError | None
    """Why it brought nothing; null: it did."""

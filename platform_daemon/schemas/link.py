"""What the process that owns the hardware and the others say to each other over the local socket."""

from __future__ import annotations

from typing import Any

from .base import Schema


class LinkCall(Schema):
    """A question or a command: one line on the socket."""

    method: str
    """Name of what is asked."""
    arguments: tuple[Any, ...]
    """Its arguments, as JSON."""


class LinkError(Schema):
    """An error on its way to the process that has asked."""

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


class LinkAnswer(Schema):
    """The answer to one call: one line on the socket."""

    value: Any
    """What it brought, as JSON; null where there is an error."""
    error: LinkError | None
    """Why it brought nothing; null: it did."""

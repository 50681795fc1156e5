"""A limit of time for what is computed in this process, where nobody can kill it: it looks at the clock itself."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from .bounds import Bounds, too_long


@dataclass(frozen=True)
class _Allowed:
    kind: str
    bounds: Bounds
    until_s: float


_allowed: ContextVar[_Allowed | None] = ContextVar("allowed", default=None)


@contextmanager
def in_time(kind: str, bounds: Bounds) -> Iterator[None]:
    """What is done within may take that time: `check_time` ends it.  A limit around it stays, if it is nearer."""
    around, until_s = _allowed.get(), time.monotonic() + bounds.time_s
    nearer = around is not None and around.until_s < until_s
    token = _allowed.set(around if nearer else _Allowed(kind, bounds, until_s))
    try:
        yield
    finally:
        _allowed.reset(token)


def check_time() -> None:
    """To be called between the parts of long work.  Raises OverBounds once the time that it may take is over."""
    allowed = _allowed.get()
    if allowed is not None and time.monotonic() > allowed.until_s:
        raise too_long(allowed.kind, allowed.bounds)

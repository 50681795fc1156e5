"""A limit of time for work in this process, which cannot be killed and therefore looks at the clock itself."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from .bounds import Bounds, too_long


@dataclass(frozen=True)
class _Deadline:
    kind: str
    bounds: Bounds
    until_s: float  # monotonic


_current: ContextVar[_Deadline | None] = ContextVar("deadline", default=None)


@contextmanager
def deadline(kind: str, bounds: Bounds) -> Iterator[None]:
    """Limit the time of the work inside the context, which calls `check_deadline`.

    Of nested deadlines the nearest one counts.
    """
    outer = _current.get()
    until_s = time.monotonic() + bounds.time_s
    outer_is_nearer = outer is not None and outer.until_s < until_s
    token = _current.set(outer if outer_is_nearer else _Deadline(kind, bounds, until_s))
    try:
        yield
    finally:
        _current.reset(token)


def check_deadline() -> None:
    """To be called between the parts of long work.  Raises OverBounds once the deadline has passed."""
    current = _current.get()
    if current is not None and time.monotonic() > current.until_s:
        raise too_long(current.kind, current.bounds)

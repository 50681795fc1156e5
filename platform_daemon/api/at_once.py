"""Work in a thread of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import anyio

ResultT = TypeVar("ResultT")


async def at_once(work: Callable[[], ResultT]) -> ResultT:
    """In a thread of its own: downloads and other long requests must not make it wait, nor it them."""
    return await anyio.to_thread.run_sync(work, limiter=anyio.CapacityLimiter(1))

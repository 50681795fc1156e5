"""Blocking work of a request in a thread that no other request can hold up."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import anyio

ResultT = TypeVar("ResultT")


async def run_in_own_thread(function: Callable[[], ResultT]) -> ResultT:
    """Call a function in a thread of its own, outside the pool of threads that other requests share and may fill.

    Raises what the function raises.
    """
    return await anyio.to_thread.run_sync(function, limiter=anyio.CapacityLimiter(1))

"""Work in a thread of its own, for what changes the thread that does it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Made = TypeVar("Made")


def in_a_thread(work: Callable[[], Made]) -> Made:
    """What it returns, or raises: the thread of the tests stays what it is."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(work).result()

"""When others had the cores, or the computer stood still: a thread that only sleeps wakes up late."""

from __future__ import annotations

import threading
import time

TICK_S = 2e-3
LATE_S = 5e-3


class Standstills(threading.Thread):
    """Sleeps and writes down when it woke late; a context manager.

    spans: (last seen awake, awake again), s by `time.monotonic`.
    """

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self._over = threading.Event()
        self.spans: list[tuple[float, float]] = []

    def run(self) -> None:
        """See threading.Thread."""
        before = time.monotonic()
        while not self._over.wait(TICK_S):
            now = time.monotonic()
            if now - before > TICK_S + LATE_S:
                self.spans.append((before, now))
            before = now

    def during(self, start_s: float, stop_s: float) -> bool:
        """Whether the computer stood still at any time between these."""
        return any(a < stop_s and b > start_s for a, b in self.spans)

    def late_s(self) -> list[float]:
        """How late it woke, each time that was late."""
        return [b - a - TICK_S for a, b in self.spans]

    def __enter__(self) -> Standstills:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self.join()


def idle_late_s(watch_s: float) -> list[float]:
    """What the computer does by itself: how late the thread wakes while this process does nothing else."""
    with Standstills() as still:
        time.sleep(watch_s)
    return still.late_s()

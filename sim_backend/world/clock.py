"""The clock of the simulated world: real time, or as fast as the computer can."""

from __future__ import annotations

import threading
import time
from datetime import UTC, datetime, timedelta

from sim_backend.options import ClockOptions


class SimulatedClock:
    """World time in seconds since construction.  Safe from any thread.

    fast: time stands still except when somebody sleeps or waits; realtime: time is that of the computer, times `speed`.
    """

    def __init__(self, options: ClockOptions) -> None:
        self.realtime = options.mode == "realtime"
        self._speed = options.speed
        self._start_utc = (options.start_utc or datetime.now(UTC)).astimezone(UTC)
        self._start_s = time.monotonic()
        self._now_s = 0.0
        self._changed = threading.Condition()

    def monotonic_s(self) -> float:
        """See drivers.clock.Clock."""
        if self.realtime:
            return (time.monotonic() - self._start_s) * self._speed
        with self._changed:
            return self._now_s

    def utc(self) -> datetime:
        """See drivers.clock.Clock."""
        return self._start_utc + timedelta(seconds=self.monotonic_s())

    def sleep(self, seconds: float) -> None:
        """See drivers.clock.Clock; fast: returns at once, with the time advanced."""
        if self.realtime:
            time.sleep(max(seconds, 0.0) / self._speed)
        else:
            with self._changed:
                self._now_s += max(seconds, 0.0)

    def wait_until(self, world_s: float, cancelled: threading.Event) -> bool:
        """Let time pass until `world_s`; False, and early, if `cancelled` is set meanwhile."""
        if not self.realtime:
            if cancelled.is_set():
                return False
            with self._changed:
                self._now_s = max(self._now_s, world_s)
            return True
        while (left := world_s - self.monotonic_s()) > 0:
            if cancelled.wait(left / self._speed):
                return False
        return not cancelled.is_set()

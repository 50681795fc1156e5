"""The clock of the simulated world: real time, or as fast as the computer allows."""

from __future__ import annotations

import threading
import time
from datetime import UTC, datetime, timedelta
from typing import Literal

from sim_backend.options import ClockOptions


class SimulatedClock:
    """World time in seconds since construction.  Any thread may call any method.

    In mode fast, world time advances only by `sleep` and `wait_until`; in mode realtime it is that of the computer,
    times `speed`.  The time of day follows world time.  In mode fast, without `start_utc`, it is never before that of
    the computer, so that no recording is stamped before the call that made it: where it would be, while the platform
    was idle, it leaps ahead.  The physics goes by `monotonic_s` and is not affected.
    """

    def __init__(self, options: ClockOptions) -> None:
        self.realtime = options.mode == "realtime"
        real = self.realtime and options.speed == 1.0 and options.start_utc is None
        self.kind: Literal["real", "simulated"] = "real" if real else "simulated"
        self._speed = options.speed
        self._start_utc = (options.start_utc or datetime.now(UTC)).astimezone(UTC)
        self._leaps = not self.realtime and options.start_utc is None
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
        if self._leaps:
            with self._changed:
                self._start_utc = max(self._start_utc, datetime.now(UTC) - timedelta(seconds=self._now_s))
        return self._start_utc + timedelta(seconds=self.monotonic_s())

    def sleep(self, seconds: float) -> None:
        """See drivers.clock.Clock; in mode fast it advances world time and returns at once."""
        if self.realtime:
            time.sleep(max(seconds, 0.0) / self._speed)
        else:
            with self._changed:
                self._now_s += max(seconds, 0.0)

    def wait_until(self, world_s: float, cancelled: threading.Event) -> bool:
        """Wait until world time `world_s`; return False, and early, if `cancelled` is set meanwhile."""
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

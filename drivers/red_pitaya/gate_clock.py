"""The end of a gate that is high by command, by the clock.

Usually the samples say when it is due.  They may come too slowly for that, or nobody reads them, because whoever does
waits for something else: a slow card, a full disk.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from drivers.errors import ShotRefused


class GateClock:
    """Calls `low` at `until_s` (monotonic) from a thread of its own, unless `stop` comes first."""

    def __init__(self, until_s: float, low: Callable[[], None]) -> None:
        self._low, self._guard = low, threading.Lock()
        self._stopped = self._rang = False
        self._timer = threading.Timer(until_s - time.monotonic(), self._ring)
        self._timer.daemon = True
        self._timer.start()

    def check(self, where: str) -> None:
        """Raises ShotRefused if it has lowered the gate."""
        if self._rang:
            raise ShotRefused(
                "the amplifier's gate had to be lowered before its end was seen",
                where=where,
                why="samples or answers come too slowly, or this computer stood still",
                remedy="repeat the shot; if it happens again, mend the network, or put the lines on AO0 ... AO2, which "
                "the card times",
            )

    def stop(self, where: str) -> None:
        """The gate is low.  Raises as `check`."""
        with self._guard:
            self._stopped = True
        self._timer.cancel()
        self.check(where)

    def _ring(self) -> None:
        with self._guard:
            if not self._stopped:
                self._rang = True
                self._low()

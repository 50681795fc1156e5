"""A timer that lowers a gate which was raised by command.

Usually the arriving samples say when the end of the gate is due.  They may arrive too slowly for that, or the thread
that reads them may be waiting for something else, such as a slow card or a full disk.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from drivers.errors import ShotRefused


class GateClock:
    """Calls `low` at `deadline_s` (monotonic) from a thread of its own, unless `stop` is called before."""

    def __init__(self, deadline_s: float, low: Callable[[], None]) -> None:
        self._low = low
        self._guard = threading.Lock()
        self._stopped = self._expired = False
        self._timer = threading.Timer(deadline_s - time.monotonic(), self._expire)
        self._timer.daemon = True
        self._timer.start()

    def check(self, where: str) -> None:
        """Raises ShotRefused if it has lowered the gate."""
        if self._expired:
            raise ShotRefused(
                "the amplifier's gate had to be lowered before its end was seen",
                where=where,
                why="samples or answers come too slowly, or this computer stood still",
                remedy="repeat the shot; if it happens again, mend the network, or put the lines on AO0 ... AO2, which "
                "the card times",
            )

    def stop(self, where: str) -> None:
        """Cancel the timer: the gate has been lowered.  Raises as `check`."""
        with self._guard:
            self._stopped = True
        self._timer.cancel()
        self.check(where)

    def _expire(self) -> None:
        with self._guard:
            if not self._stopped:
                self._expired = True
                self._low()

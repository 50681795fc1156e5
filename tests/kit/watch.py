"""How long a process stands still, because a busy computer lets others run."""

from __future__ import annotations

import threading
import time
from typing import Self

LOOK_S, STILL_S = 0.01, 0.03


class Watch:
    """longest_s: how long this process stood still at most; total_s: in all, in pieces of more than STILL_S."""

    def __init__(self) -> None:
        self.longest_s, self.total_s, self._over = 0.0, 0.0, threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _look(self) -> None:
        last = time.monotonic()
        while not self._over.wait(LOOK_S):
            now = time.monotonic()
            self.longest_s = max(self.longest_s, now - last)
            self.total_s += now - last if now - last > STILL_S else 0.0
            last = now

"""How often a client may ask."""

from __future__ import annotations

import math
import time
from collections import OrderedDict
from collections.abc import Callable

from .refusals import TooManyRequests

MOST_CLIENTS = 4096  # that are remembered; of more, those that asked longest ago begin anew


class Rate:
    """A bucket per client: so many requests at once, and so many a second on average.  For one thread."""

    def __init__(self, per_s: float, burst: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_s, self._burst, self._clock = per_s, burst, clock
        self._empty_at: OrderedDict[str, float] = OrderedDict()  # when the bucket will have run empty

    def count(self, client: str) -> None:
        """One more request.  Raises TooManyRequests with the seconds to wait."""
        now = self._clock()
        due = max(self._empty_at.pop(client, now), now) + 1 / self._per_s
        late = due - now - self._burst / self._per_s
        self._empty_at[client] = due if late <= 0 else due - 1 / self._per_s
        while len(self._empty_at) > MOST_CLIENTS:
            self._empty_at.popitem(last=False)
        if late > 0:
            what = f"this client asks more often than {self._per_s:g} times a second"
            remedy = "ask less often: a job's progress changes with its shots, the platform's state every second"
            raise TooManyRequests(what, wait_s=max(1, math.ceil(late)), remedy=remedy)

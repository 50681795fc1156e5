"""How much clients may ask for at once.  One object, so that a test can make it small."""

from __future__ import annotations

import os
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Bounds of what clients can make the server hold.

    Attributes:
        body_bytes, body_s: longest body of a request, and how long it may take to arrive.
        connections: open at once on the main port; beyond that uvicorn answers 503.
        keep_alive_s: how long a connection is kept open after an answer, without another request.
        stalled_s: how long a client may leave an answer unread.
        requests_per_s, burst: of one client, on average and all at once.
        computing, converting, reading: requests at once that compute for seconds, that make dm/dt, that read files;
            half of the cores are left to the shots and to requests that only look.
        downloading: answers at once that are held in memory until they are sent.
        waiting, patience_s: how many requests may wait for each of these, and how long.
    """

    body_bytes: int = 1_000_000
    body_s: float = 30.0
    connections: int = 200
    keep_alive_s: int = 10
    stalled_s: float = 30.0
    requests_per_s: float = 300.0
    burst: int = 600
    computing: int = max(1, min(4, (os.cpu_count() or 1) // 2))
    converting: int = 1
    reading: int = 4
    downloading: int = 4
    waiting: int = 64
    patience_s: float = 60.0

"""How much anybody may ask for at once.  One object, so that a test can make it small."""

from __future__ import annotations

import os
from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Bounds of what a client can make the server hold.

    Attributes:
        body_bytes, body_s: longest body of a request, and how long it may take to come.
        headers_s: how long the head of a request may take.
        stalled_s: how long a client may leave an answer unread.
        connections, handshakes: that are open at once, and that are not through with TLS yet.
        connections_per_client: of these, of one address (of IPv6 its /64); fifty pages that listen and fifty that poll
            are a hundred.
        requests_per_s, burst: of one client, on average and all at once.
        computing, converting, reading: requests at once that compute for seconds, that make dm/dt, that read files;
            half of the cores are left to the shots and to those who only look.
        downloading: answers at once that are held in memory until they are sent.
        waiting, patience_s: how many may wait for each of them, and how long.
    """

    body_bytes: int = 1_000_000
    body_s: float = 30.0
    headers_s: float = 10.0
    stalled_s: float = 30.0
    connections: int = 200
    connections_per_client: int = 150
    handshakes: int = 100
    requests_per_s: float = 300.0
    burst: int = 600
    computing: int = max(1, (os.cpu_count() or 1) // 2)
    converting: int = 1
    reading: int = 4
    downloading: int = 4
    waiting: int = 64
    patience_s: float = 60.0

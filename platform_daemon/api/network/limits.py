"""How much anybody may ask for at once.  One object, so that a test can make it small."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Bounds of what a client can make the server hold.

    Attributes:
        body_bytes, body_s: longest body of a request, and how long it may take to come.
        headers_s: how long the head of a request may take.
        stalled_s: how long a client may leave an answer unread.
        connections: that are open at once.
        requests_per_s, burst: of one client, on average and all at once.
        computing, reading, downloading: requests at once that compute, that read files, whose answer is held in
            memory until it is sent.
        waiting, patience_s: how many may wait for each of them, and how long.
    """

    body_bytes: int = 1_000_000
    body_s: float = 30.0
    headers_s: float = 10.0
    stalled_s: float = 30.0
    connections: int = 200
    requests_per_s: float = 300.0
    burst: int = 600
    computing: int = 2
    reading: int = 4
    downloading: int = 8
    waiting: int = 64
    patience_s: float = 60.0

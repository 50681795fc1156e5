"""Asks again and again, one at a time, and notes how long each answer took."""

from __future__ import annotations

import http.client
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Latencies:
    """Seconds, ascending; refused: how many answers were not 200, or did not come."""

    seconds: tuple[float, ...]
    refused: int

    def at(self, share: float) -> float:
        """So large a share took no longer."""
        return (
            self.seconds[min(len(self.seconds) - 1, int(share * len(self.seconds)))] if self.seconds else float("nan")
        )


def asked(method: str, port: int, path: str, until: float, every_s: float) -> Latencies:
    """Each on a connection of its own, as of somebody who comes running."""
    took, refused = [], 0
    while time.monotonic() < until:
        began = time.monotonic()
        link = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
        try:
            link.request(method, path)
            answer = link.getresponse()
            answer.read()
            refused += answer.status != 200
        except (OSError, http.client.HTTPException):
            refused += 1
        finally:
            link.close()
        took.append(time.monotonic() - began)
        time.sleep(max(0.0, every_s - took[-1]))
    return Latencies(tuple(sorted(took)), refused)

"""Things that go wrong between a device and its driver, on purpose.  World faults are in sim_backend/faults.py.

timeout        one answer never comes
garbage        one answer is replaced by as many random bytes
half_reply     one answer stops half-way
disconnect     the connection ends after byte `at_byte` of what the device sends
slow_link      answers come `delay_s` late, `count` of them
one_way_link   what the device is told arrives, what it says does not, until `clear()`
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from sim_backend.section import NonNegative, Section

Kind = Literal["timeout", "garbage", "half_reply", "disconnect", "slow_link", "one_way_link"]


class WireFault(Section):
    """One fault: it strikes after `after` whole answers; `count` answers are hit; `delay_s` is for slow_link, `at_byte`
    for disconnect, counted from the answer it strikes."""

    kind: Kind
    device: Annotated[str, Field(min_length=1)]
    stream: Literal["command", "data"] = "command"
    after: Annotated[int, Field(ge=0)] = 0
    count: Annotated[int, Field(ge=1)] = 1
    delay_s: NonNegative = 0.2
    at_byte: Annotated[int, Field(ge=0)] = 0


class Hangup(Exception):
    """The device's connection ends now, after `last` has been sent."""

    def __init__(self, last: bytes = b"") -> None:
        self.last = last


@dataclass
class _Armed:
    fault: WireFault
    answers: int = 0
    sent: int = 0


class WireFaults:
    """The faults of one device.  Safe from any thread."""

    def __init__(self, seed: int, name: str) -> None:
        self._lock = threading.Lock()
        self._rng = np.random.default_rng([seed, *name.encode()])
        self._armed: list[_Armed] = []

    def arm(self, fault: WireFault) -> None:
        """Let a fault strike from now on."""
        with self._lock:
            self._armed.append(_Armed(fault))

    def clear(self) -> None:
        """Forget all faults."""
        with self._lock:
            self._armed.clear()

    def outgoing(self, answer: bytes, stream: str = "command") -> bytes:
        """What of an answer gets through.  Raises Hangup, sleeps for a slow link."""
        delay_s = 0.0
        with self._lock:
            for armed in list(self._armed):
                if armed.fault.stream == stream:
                    answer, late_s = self._struck(armed, answer)
                    delay_s += late_s
        if delay_s:
            time.sleep(delay_s)
        return answer

    def _struck(self, armed: _Armed, answer: bytes) -> tuple[bytes, float]:
        fault, index = armed.fault, armed.answers
        armed.answers += 1
        if index < fault.after:
            return answer, 0.0
        if fault.kind == "one_way_link":
            return b"", 0.0
        if fault.kind == "disconnect":
            left, armed.sent = fault.at_byte - armed.sent, armed.sent + len(answer)
            if len(answer) < left:
                return answer, 0.0
            self._armed.remove(armed)
            raise Hangup(answer[:left])
        if index + 1 >= fault.after + fault.count:
            self._armed.remove(armed)
        if fault.kind == "slow_link":
            return answer, fault.delay_s
        if fault.kind == "half_reply":
            return answer[: len(answer) // 2], 0.0
        return self._rng.bytes(len(answer)) if fault.kind == "garbage" else b"", 0.0

"""Things that go wrong between a device and its driver, on purpose.  World faults are in sim_backend/world/faults.py.

timeout        one answer never comes
garbage        one answer is replaced by as many random bytes
half_reply     one answer stops half-way
disconnect     the connection ends after byte `at_byte` of what the device sends
slow_link      answers come `delay_s` late, `count` of them
one_way_link   what the driver sends arrives, what the device sends does not, until `clear()`
deaf_link      the other direction: what the driver sends does not arrive, until `clear()`
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from sim_backend.section import NonNegative, Section
from sim_backend.world.world import World

Kind = Literal["timeout", "garbage", "half_reply", "disconnect", "slow_link", "one_way_link", "deaf_link"]
Moment = Literal["any", "idle", "shot", "after_shot"]


class WireFault(Section):
    """One fault: it strikes after `after` whole answers; `count` answers are hit; `delay_s` is for slow_link, `at_byte`
    for disconnect, counted from the answer it strikes.

    Only answers count that are given to a command that contains the text `command`, at the moment `when`: while no shot
    runs, while one does, or after the next one.
    """

    kind: Kind
    device: Annotated[str, Field(min_length=1)]
    stream: Literal["command", "data"] = "command"
    after: Annotated[int, Field(ge=0)] = 0
    count: Annotated[int, Field(ge=1)] = 1
    delay_s: NonNegative = 0.2
    at_byte: Annotated[int, Field(ge=0)] = 0
    command: str = ""
    when: Moment = "any"


class Hangup(Exception):
    """The device's connection ends now, after `last` has been sent."""

    def __init__(self, last: bytes = b"") -> None:
        self.last = last


@dataclass
class _Armed:
    fault: WireFault
    shots_before: int
    answers: int = 0
    sent: int = 0

    def fits(self, command: str, stream: str, world: World) -> bool:
        """True if this is one of the answers that count, or the first of those that follow it in a broken link."""
        fault = self.fault
        if fault.stream != stream or not (fault.command.upper() in command.upper() or self.sent):
            return False
        if fault.when == "any":
            return True
        if world.is_running():
            return fault.when == "shot"
        return fault.when == "idle" or (fault.when == "after_shot" and world.shots > self.shots_before)


class WireFaults:
    """The faults of one device.  Safe from any thread.  `strikes` are the world times s at which one struck."""

    def __init__(self, seed: int, name: str, world: World) -> None:
        self._lock = threading.Lock()
        self._rng = np.random.default_rng([seed, *name.encode()])
        self._world = world
        self._armed: list[_Armed] = []
        self._dead: str | None = None
        self.strikes: list[float] = []

    def arm(self, fault: WireFault) -> None:
        """Let a fault strike from now on."""
        with self._lock:
            self._armed.append(_Armed(fault, self._world.shots))

    def clear(self) -> None:
        """Forget all faults, and what has struck."""
        with self._lock:
            self._armed.clear()
            self._dead = None
            self.strikes.clear()

    def hears(self, command: str) -> bool:
        """False if what the driver sends does not arrive."""
        with self._lock:
            for armed in list(self._armed):
                if armed.fault.kind == "deaf_link" and armed.fits(command, "command", self._world):
                    armed.answers += 1
                    if armed.answers > armed.fault.after:
                        self._strike(armed)
                        self._dead = "deaf_link"
            return self._dead != "deaf_link"

    def outgoing(self, answer: bytes, stream: str = "command", command: str = "") -> bytes:
        """What of an answer gets through.  Raises Hangup, sleeps for a slow link."""
        delay_s = 0.0
        with self._lock:
            if self._dead == f"one_way_link {stream}":
                return b""
            for armed in list(self._armed):
                if armed.fault.kind != "deaf_link" and armed.fits(command, stream, self._world):
                    answer, late_s = self._struck(armed, answer)
                    delay_s += late_s
        if delay_s:
            time.sleep(delay_s)
        return answer

    def _strike(self, armed: _Armed, *, over: bool = True) -> None:
        self.strikes.append(self._world.clock.monotonic_s())
        if over:
            self._armed.remove(armed)

    def _struck(self, armed: _Armed, answer: bytes) -> tuple[bytes, float]:
        fault = armed.fault
        index = armed.answers
        armed.answers += 1
        if index < fault.after:
            return answer, 0.0
        if fault.kind == "one_way_link":
            self._strike(armed)
            self._dead = f"one_way_link {fault.stream}"
            return b"", 0.0
        if fault.kind == "disconnect":
            left = fault.at_byte - armed.sent
            armed.sent = armed.sent + len(answer)
            if len(answer) < left:
                return answer, 0.0
            self._strike(armed)
            raise Hangup(answer[:left])
        self._strike(armed, over=index + 1 >= fault.after + fault.count)
        if fault.kind == "slow_link":
            return answer, fault.delay_s
        if fault.kind == "half_reply":
            return answer[: len(answer) // 2], 0.0
        return self._rng.bytes(len(answer)) if fault.kind == "garbage" else b"", 0.0

"""Injected time, so that a night of shots can run in seconds on a simulated platform."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import Literal, Protocol


class Clock(Protocol):
    """Time as the platform sees it."""

    @property
    def realtime(self) -> bool:
        """Whether time passes by itself; otherwise it passes only while a caller sleeps or waits."""

    @property
    def kind(self) -> Literal["real", "simulated"]:
        """real: the time of this computer; simulated: it passes faster or slower, or begins on another date."""

    def monotonic_s(self) -> float:
        """Seconds since some fixed instant; never jumps."""

    def utc(self) -> datetime:
        """Time of day, time-zone aware."""

    def sleep(self, seconds: float) -> None:
        """Let `seconds` pass for the platform."""


class SystemClock:
    """The time of this computer."""

    realtime = True
    kind: Literal["real", "simulated"] = "real"

    def monotonic_s(self) -> float:
        """See Clock."""
        return time.monotonic()

    def utc(self) -> datetime:
        """See Clock."""
        return datetime.now(UTC)

    def sleep(self, seconds: float) -> None:
        """See Clock."""
        time.sleep(seconds)

"""What happened in the world: when power could reach the coils, and every time the interlock failed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Violation:
    """The interlock failed: world time s, number of the shot, and what happened."""

    time_s: float
    shot: int
    cause: str

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {"time_s": self.time_s, "shot": self.shot, "cause": self.cause}


@dataclass(frozen=True)
class PowerSpan:
    """Power could reach the coils from `start_s` to `stop_s` (world time) in a shot."""

    shot: int
    start_s: float
    stop_s: float

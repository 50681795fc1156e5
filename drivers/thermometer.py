"""Contract of the temperature sensor at the resonator."""

from __future__ import annotations

from typing import Protocol


class Thermometer(Protocol):
    """Temperature at the resonator."""

    def temperature_c(self) -> float:
        """Latest reading, deg C.  Raises DeviceTimeout."""

    def close(self) -> None:
        """Let go.  Idempotent."""

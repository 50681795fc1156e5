"""What a device says of itself."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Identity:
    """Manufacturer, model, serial number and firmware, as read from the device; empty where it is not reported."""

    manufacturer: str
    model: str
    serial: str = ""
    firmware: str = ""

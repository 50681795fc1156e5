"""Reads back every device, and keeps the last thing that went wrong with each."""

from __future__ import annotations

import threading
from dataclasses import asdict
from typing import Any

from drivers.errors import PlatformError
from drivers.inventory import DeviceReport, report_platform
from drivers.platform import Platform


class Readback:
    """The devices as last read back.  One thread at a time writes it, anybody may read it."""

    def __init__(self, platform: Platform) -> None:
        self._platform = platform
        self._lock = threading.Lock()
        self._last_errors: dict[str, dict[str, str]] = {}
        self._rows: dict[str, dict[str, Any]] = {}
        self.devices: list[dict[str, Any]] = []
        self.status: dict[str, Any] = {}

    def refresh(self, *, busy: bool = False) -> None:
        """Ask all devices, of a busy platform all but its card.  Raises the first device's error after all have been
        asked."""
        with self._lock:
            self._refresh(busy)

    def _refresh(self, busy: bool) -> None:
        now = self._platform.clock.utc().isoformat()
        reports = report_platform(self._platform, busy=busy)
        for each in reports:
            if each.error is not None:
                self.note(each.device, each.error)
        rows = {r.device: {**r.as_dict(), "read_at": now} for r in reports}
        self._rows = {**self._rows, **rows}
        self.devices = [{**row, "last_error": self._last_errors.get(name)} for name, row in self._rows.items()]
        failed = next((r.error for r in reports if r.error is not None), None)
        if failed is not None:
            self.status = {**self.status, "error": str(failed)}
            raise failed
        self.status = {**self.status, **_status(self._platform, {r.device: r for r in reports}), "read_at": now}

    def note(self, device: str, error: PlatformError) -> None:
        """Keep an error as the last one of a device."""
        self._last_errors[device] = {"error": str(error), "at": self._platform.clock.utc().isoformat()}


def _status(platform: Platform, found: dict[str, DeviceReport]) -> dict[str, Any]:
    """Identity and state of each device, units in the names."""
    thermometer = found.pop("thermometer", None)
    return {
        "platform": platform.name,
        **{name: {"identity": asdict(r.identity) if r.identity else None, **r.state} for name, r in found.items()},
        "temperature_c": None if thermometer is None else thermometer.state["temperature_c"],
        "error": None,
    }

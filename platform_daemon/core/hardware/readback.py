"""Reads back every device, and keeps the last thing that went wrong with each."""

from __future__ import annotations

import threading
from typing import Any

from drivers.inventory import report_platform
from drivers.platform import Platform
from platform_daemon.core.jobs.events import EventSink, null_sink
from platform_daemon.core.schemas.calibrations import CalibrationsInUse
from platform_daemon.core.schemas.events import DeviceEvent
from platform_daemon.core.schemas.platform import DeviceError, DeviceReadback, PlatformStatus


class Readback:
    """The devices as last read back.  One thread at a time writes it, anybody may read it.

    tell: of devices that do not answer, and that do again.
    """

    def __init__(self, platform: Platform, tell: EventSink = null_sink) -> None:
        self._platform, self._tell = platform, tell
        self._broken: set[str] = set()
        self._lock = threading.Lock()
        self._last_errors: dict[str, DeviceError] = {}
        self._rows: dict[str, DeviceReadback] = {}
        self._answers: dict[str, DeviceReadback] = {}  # of the last time that all answered
        self._error: str | None = None
        self._read_at = ""

    def refresh(self, *, busy: bool = False) -> None:
        """Ask all devices, of a busy platform all but its card.

        Raises the first device's error after all have been asked; not that of the thermometer, which is shown only.
        """
        with self._lock:
            self._refresh(busy)

    def _refresh(self, busy: bool) -> None:
        now = self._platform.clock.utc().isoformat()
        reports = report_platform(self._platform, busy=busy)
        for each in reports:
            if (each.error is not None) != (each.device in self._broken):
                self._broken ^= {each.device}
                self._tell(DeviceEvent(device=each.device, error=None if each.error is None else str(each.error)))
            if each.error is not None:
                self._last_errors[each.device] = DeviceError(error=str(each.error), at=now)
        rows = {
            r.device: DeviceReadback(**r.as_dict(), read_at=now, last_error=self._last_errors.get(r.device))
            for r in reports
        }
        self._rows = {**self._rows, **rows}
        errors = {r.device: r.error for r in reports if r.error is not None}
        first = next(iter(errors.values()), None)
        self._error = None if first is None else str(first)
        for device, error in errors.items():
            if device != "thermometer":  # which is looked at and decides nothing
                raise error
        self._answers, self._read_at = {**self._answers, **rows}, now

    @property
    def devices(self) -> tuple[DeviceReadback, ...]:
        """Each device as it was last queried."""
        return tuple(self._rows.values())

    def status(
        self, calibrations: CalibrationsInUse, interlock: str | None, running: str | None, queued: tuple[str, ...]
    ) -> PlatformStatus:
        """Identity and state of each device when all answered last, and the job."""
        found = dict(self._answers)
        thermometer = found.pop("thermometer", None)
        devices: dict[str, Any] = {n: {"identity": r.identity, **dict(r.state)} for n, r in found.items()}
        return PlatformStatus(
            platform=self._platform.name,
            **devices,
            temperature_c=None if thermometer is None else dict(thermometer.state).get("temperature_c"),
            error=self._error,
            read_at=self._read_at,
            calibration=calibrations.calibration,
            transmit_calibration=calibrations.transmit_calibration,
            interlock=interlock,
            running=running,
            queued=queued,
        )

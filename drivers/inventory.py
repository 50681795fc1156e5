"""Identity and state of each device of a platform; a device that fails does not keep the others from being read."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from drivers.errors import PlatformError
from drivers.identity import Identity
from drivers.platform import Backend, Platform
from drivers.registry import DeviceSection, PlatformSection, load_backend
from drivers.thermometer import plausible_temperature_c

KINDS = ("io_card", "tx_rx_switch", "power_amplifier", "lna", "thermometer")


@dataclass(frozen=True)
class DeviceReport:
    """One device: its role in the platform, its identity, its state as name -> plain value, and its error, if any."""

    device: str
    identity: Identity | None = None
    state: Mapping[str, Any] = field(default_factory=dict)
    error: PlatformError | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {
            "device": self.device,
            "identity": None if self.identity is None else asdict(self.identity),
            "state": dict(self.state),
            "error": None if self.error is None else str(self.error),
        }


def report(kind: str, device: Any) -> DeviceReport:
    """Read one device back; an error becomes part of the report."""
    try:
        identity = device.identity() if kind != "thermometer" else None
        return DeviceReport(kind, identity, _STATES[kind](device))
    except PlatformError as error:
        return DeviceReport(kind, error=error)


def report_platform(platform: Platform, *, busy: bool = False) -> list[DeviceReport]:
    """All devices of a platform that is open; busy: without the card, which is in the middle of a shot.  For the thread
    that owns the hardware."""
    parts = (platform.card, platform.switch, platform.amplifier, platform.lna, platform.thermometer)
    found = [(kind, part) for kind, part in zip(KINDS, parts, strict=True) if part is not None]
    return [report(kind, part) for kind, part in (found[1:] if busy else found)]


def find_devices(section: PlatformSection) -> list[DeviceReport]:
    """Open each device that a platform file names, read it back, and close them all; outputs stay off.

    A device that cannot be opened is a report with its error, and does not keep the others from being tried.
    """
    backends: dict[str, Backend] = {}
    found = []
    with contextlib.ExitStack() as opened:
        for kind in KINDS:
            table: DeviceSection | None = getattr(section, kind)
            if table is not None:
                found.append(_found(kind, table, section, backends, opened))
    return found


def _found(
    kind: str,
    table: DeviceSection,
    section: PlatformSection,
    backends: dict[str, Backend],
    opened: contextlib.ExitStack,
) -> DeviceReport:
    try:
        name = table.backend
        if name not in backends:
            backends[name] = load_backend(name, section.backends.get(name, {}))
        device = getattr(backends[name], kind)(table.options())
    except PlatformError as error:
        return DeviceReport(kind, error=error)
    opened.callback(_closed, device)
    return report(kind, device)


def _closed(device: Any) -> None:
    with contextlib.suppress(PlatformError):  # its report is made already
        device.close()


def _card(card: Any) -> dict[str, Any]:
    can = card.capabilities()
    return {
        "state": str(card.state()),
        "inputs": can.inputs,
        "outputs": can.outputs,
        "sampling_rate_hz": can.clock.rate_hz,
    }


def _switch(switch: Any) -> dict[str, Any]:
    return {"position": str(switch.position()), "total_time_s": switch.timing().total_s}


def _amplifier(amplifier: Any) -> dict[str, Any]:
    return asdict(amplifier.status())


def _lna(lna: Any) -> dict[str, Any]:
    return {"gain": lna.gain(), "overloaded": lna.overloaded()}


def _thermometer(thermometer: Any) -> dict[str, Any]:
    return {"temperature_c": plausible_temperature_c(thermometer)}


_STATES = {
    "io_card": _card,
    "tx_rx_switch": _switch,
    "power_amplifier": _amplifier,
    "lna": _lna,
    "thermometer": _thermometer,
}

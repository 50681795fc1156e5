"""Switches the outputs of a platform off from its file alone, whatever state its owner left it in."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from drivers.errors import DeviceFault
from drivers.platform import Backend, Step, refuse_failures
from drivers.registry import DeviceSection, PlatformSection, load_backend
from drivers.tx_rx_switch import SwitchPosition


def switch_outputs_off(section: PlatformSection) -> None:
    """Open card, amplifier and switch, all at once; stop, disable, disconnect the receiver; let them go again.

    Devices on the card's lines come after the card.  Raises ConfigError, and OutputsUnconfirmed that lists all that
    failed; everything else has been switched off then.
    """
    tables = _tables(section)
    backends = output_backends(section)
    opened: list[Any] = []

    def off(kind: str, act: Callable[[Any], None]) -> Callable[[], None]:
        def step() -> None:
            device = getattr(backends[tables[kind].backend], kind)(tables[kind].options())
            opened.append(device)
            act(device)

        step.__qualname__ = kind
        return step

    card = Step(off("io_card", lambda d: d.stop()))
    on_card = tables["power_amplifier"].backend == tables["io_card"].backend
    amplifier = Step(off("power_amplifier", lambda d: d.disable()), after=card if on_card else None)
    switch = Step(off("tx_rx_switch", _disconnect), after=card)
    failures = [each.failure() for each in (card, amplifier, switch)]
    for device in reversed(opened):
        with suppress(Exception):  # outputs are off, or are among the failures
            device.close()
    refuse_failures(failures)


def output_backends(section: PlatformSection) -> dict[str, Backend]:
    """The back ends of the three, by name, with nothing opened.  Raises ConfigError."""
    names = {table.backend for table in _tables(section).values()}
    return {name: load_backend(name, section.backends.get(name, {})) for name in names}


def _tables(section: PlatformSection) -> dict[str, DeviceSection]:
    return {kind: getattr(section, kind) for kind in ("io_card", "power_amplifier", "tx_rx_switch")}


def _disconnect(switch: Any) -> None:
    """Raises DeviceFault unless the receiver is read back disconnected."""
    switch.to_transmit()
    if switch.position() is not SwitchPosition.TRANSMIT:
        raise DeviceFault("the receiver is not confirmed disconnected", where="tx_rx_switch", remedy="check the switch")

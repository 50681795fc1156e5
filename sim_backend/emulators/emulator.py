"""A whole lab behind its wires: one simulated world, and whatever listens for it.

emulator = LabEmulator(tables, folder)      # tables of the TOML file; paths in it count from its folder
emulator.endpoints()                        # what to write into a platform file
emulator.close()
"""

from __future__ import annotations

import shutil
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from drivers.errors import ConfigError
from drivers.specimen import Specimen
from drivers.text_files import read_text_file
from drivers.validation import validated
from sim_backend.devices.reference import SimulatedReferenceDipole
from sim_backend.options import SimulatedOptions
from sim_backend.world.warm_up import warm_up
from sim_backend.world.world import World

from .control import Control, arm
from .io_card.board import Board
from .io_card.daq_server import DaqServer
from .io_card.session import Cards
from .listening import Listener
from .options import EmulatorOptions
from .serial.lna import LnaController
from .serial.serial_port import SerialPort
from .serial.switch import SwitchController
from .usb.amplifier import AmplifierScpi
from .usb.usb_server import UsbServer
from .usb.usbtmc import UsbIdentity, UsbTmcDevice
from .wire_faults import WireFaults

AMPLIFIER = "amplifier"


class LabEmulator:
    """See the module.  Raises ConfigError for a bad table, file, port or path; nothing listens then."""

    def __init__(self, tables: Mapping[str, Any], folder: Path) -> None:
        self.options = validated(EmulatorOptions, tables, "emulator")
        self.world = _world(self.options, folder)
        self.cards = Cards(self.world, self.options.io_cards)
        self.faults: dict[str, WireFaults] = {}
        self._folder: Path | None = None
        self._closing: list[Callable[[], None]] = []
        try:
            self._open()
            for fault in self.options.wire_faults:
                arm(self.faults, fault)
        except Exception:
            self.close()
            raise
        warm_up()

    def endpoints(self) -> dict[str, Any]:
        """Where everything listens: plain JSON types."""
        host = self.options.host
        options = self.options.amplifier
        usb = {
            "host": host,
            "port": self._usb.port if self._usb is not None else 0,
            "vendor_id": options.vendor_id,
            "product_id": options.product_id,
            "serial": options.serial,
        }
        return {
            "io_cards": [
                {"host": host, "command_port": s.command_port, "data_port": s.data_port} for s in self._servers
            ],
            "serial": {name: str(port.link) for name, port in self._serial.items()},
            "usb": {} if self._usb is None else {AMPLIFIER: usb},
            "control": {"host": host, "port": self._control.port},
        }

    def close(self) -> None:
        """Everything stops listening; what was made on disk goes."""
        for close in reversed(self._closing):
            close()
        self._closing.clear()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None
        self.world.stop()

    def kill_server(self, number: int) -> None:
        """The process of a card's server ends at once; the card itself plays on."""
        self._servers[number].close()

    def start_server(self, number: int) -> None:
        """It starts again, at the same ports, and loads the card's image: all its registers are as new.

        Raises ConfigError if another program has taken a port meanwhile.
        """
        before = self._servers[number]
        board = self.cards.boards[number]
        at = {"command_port": before.command_port, "data_port": before.data_port}
        board.power_up(board.options.model_copy(update=at))
        self._servers[number] = DaqServer(board, self.options.host, self.faults[f"io_card_{number}"])
        self._closing.append(self._servers[number].close)

    def _open(self) -> None:
        self._servers = [self._card(k) for k in range(len(self.options.io_cards.boards))]
        self._serial = {name: self._port(name) for name in self.options.serial}
        self._usb = self._amplifier()
        table = self.options.reference_dipole
        dipole = None if table is None else SimulatedReferenceDipole(self.world, table)
        self._control = Listener(
            self.options.host, self.options.control_port, Control(self.cards, self.faults, dipole).serve, "control"
        )
        self._closing.append(self._control.close)

    def _wire(self, name: str) -> WireFaults:
        self.faults[name] = WireFaults(self.options.seed, name, self.world)
        return self.faults[name]

    def _card(self, number: int) -> DaqServer:
        board = Board(self.cards, self.options.io_cards.boards[number])
        self.cards.boards.append(board)
        server = DaqServer(board, self.options.host, self._wire(f"io_card_{number}"))
        self._closing.append(server.close)
        return server

    def _port(self, name: str) -> SerialPort:
        options = self.options.serial[name]
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="lab-emulator-"))
        link = Path(options.link) if options.link is not None else self._folder / name
        device = (
            SwitchController(self.cards, options.serial)
            if options.kind == "switch"
            else LnaController(self.world, options.serial)
        )
        port = SerialPort(link, device, self._wire(name))
        self._closing.append(port.close)
        return port

    def _amplifier(self) -> UsbServer | None:
        options = self.options.amplifier
        if options.kind == "line":
            self.world.amplifier(enabled=True, muted=False)
            return None
        identity = UsbIdentity(options.vendor_id, options.product_id, options.serial)
        device = UsbTmcDevice(identity, AmplifierScpi(self.world, options.serial))
        server = UsbServer(device, self.options.host, options.port, self._wire(AMPLIFIER))
        self._closing.append(server.close)
        return server


def _world(options: EmulatorOptions, folder: Path) -> World:
    """The world of the platform file, with the changes of [world], in real time at the requested speed."""
    table = _merged(_simulated(options, folder), options.world)
    table = _merged(table, {"clock": {"mode": "realtime", "speed": options.speed}})
    world = World(validated(SimulatedOptions, table, "world"))
    if options.lna_gain is not None:
        if options.lna_gain not in world.options.lna.gains:
            raise ConfigError(
                f"the LNA has no gain {options.lna_gain:g}",
                where="lna_gain",
                remedy=f"use one of {world.options.lna.gains}",
            )
        world.lna_gain = options.lna_gain
    if options.specimen is not None:
        world.mount(validated(Specimen, _toml(folder / options.specimen), options.specimen))
    return world


def _simulated(options: EmulatorOptions, folder: Path) -> dict[str, Any]:
    if options.platform is None:
        return {}
    found = _toml(folder / options.platform).get("backends", {}).get("simulated")
    if found is None:
        raise ConfigError(
            "has no table [backends.simulated]", where=options.platform, remedy="name a simulated platform's file"
        )
    return dict(found)


def _toml(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(read_text_file(path))
    except OSError as error:
        raise ConfigError(
            "cannot be read", where=str(path), why=error.strerror or "", remedy="correct the path"
        ) from None
    except ValueError as error:
        raise ConfigError("is no TOML", where=str(path), why=str(error), remedy="correct the file") from None


def _merged(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    out = dict(table)
    for key, value in changes.items():
        old = out.get(key)
        out[key] = _merged(old, value) if isinstance(value, Mapping) and isinstance(old, Mapping) else value
    return out

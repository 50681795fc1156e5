"""An emulated lab in this process, and platforms that are joined to it by the real wires."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drivers.platform import Platform
from drivers.red_pitaya.connection import Connection
from drivers.red_pitaya.pairing import open_pair
from drivers.registry import build_platform
from platform_daemon.core.guard.emergency_off import reset_fault
from platform_daemon.core.guard.fault_latch import Fault
from platform_daemon.core.hardware.shot import RawShot, run_shot
from platform_daemon.core.settings import PlatformFile, apply_override, load_platform, locate, read_toml
from sequences.compiler import ShotPlan
from sim_backend.emulators.emulator import LabEmulator


def lines_at(gate: str, receiver: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Board and pin of both lines, `0 AO0`: overrides of the emulator and of the platform."""
    emulator, platform = [], []
    for line, at in (("pa_gate", gate), ("rx_connect", receiver)):
        board, pin = at.split()
        emulator.append(f'io_cards.{line}={{board={board}, output="{pin}"}}')
        platform.append(f'io_card.lines.{line}={{board={board}, pin="{pin}"}}')
    return tuple(emulator), tuple(platform)


class Lab:
    """An emulator and the file of its endpoints."""

    def __init__(self, folder: Path, *overrides: str) -> None:
        path = locate("emulators", "lab")
        tables, _ = read_toml(path)
        for override in overrides:
            apply_override(tables, override)
        self.emulator = LabEmulator(tables, path.parent)
        self.endpoints = folder / "endpoints.json"
        self.endpoints.write_text(json.dumps(self.emulator.endpoints()))

    def file(self, *overrides: str) -> PlatformFile:
        """The shipped platform file of the emulated lab."""
        return load_platform("emulated", overrides, self.endpoints)

    def platform(self, *overrides: str) -> Platform:
        """A platform on the emulated wires."""
        return build_platform(self.file(*overrides).section)

    def control(self, do: str, **arguments: Any) -> Any:
        """Ask the emulator's door into the world."""
        at = self.emulator.endpoints()["control"]
        with socket.create_connection((at["host"], at["port"]), 5) as link, link.makefile("rwb") as stream:
            stream.write(json.dumps({"do": do, **arguments}).encode() + b"\n")
            stream.flush()
            answer = json.loads(stream.readline())
        assert answer["ok"], answer
        return answer["result"]

    def cut_links(self) -> Callable[[], bool]:
        """No byte passes to or from the cards any more, until `clear_faults`; whether outputs or gate are on."""
        for board in range(len(self.emulator.endpoints()["io_cards"])):
            for kind, stream in (("deaf_link", "command"), ("one_way_link", "command"), ("one_way_link", "data")):
                self.control("wire_fault", kind=kind, device=f"io_card_{board}", stream=stream)

        def on() -> bool:
            now = self.control("outputs")
            return bool(now["playing"]) or bool(now["pa_gate"])

        return on

    def kill_server(self, board: int) -> None:
        """The process of a card's server is killed; its card goes on."""
        self.emulator.kill_server(board)

    def start_server(self, board: int) -> None:
        """It is started again, on the same ports, and loads the card anew."""
        self.emulator.start_server(board)

    def reset_fault(self) -> Fault | None:
        """What a person does after an owner has died; the fault that stood."""
        return reset_fault(self.file().section, "a test", "an owner was killed on purpose")

    def violations(self) -> tuple[Any, ...]:
        """Every time power met a connected receiver."""
        return self.emulator.world.violations()


def watched_shot(platform: Platform, shot: ShotPlan) -> RawShot:
    """A shot whose switch this machine could watch: a busy one is sometimes too late for that, and says so."""
    for _ in range(10):
        raw = run_shot(platform, shot)
        if "the host was too late" not in (raw.reason or ""):
            break
    return raw


def intruder(lab: Lab, board: int = 0) -> Connection:
    """Another client of the card, as a daemon on another computer would be."""
    at = lab.emulator.endpoints()["io_cards"][board]
    return open_pair(at["host"], (at["command_port"], at["data_port"]), 2.0, ())

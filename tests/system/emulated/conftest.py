"""An emulated lab in this process, and platforms that are joined to it by the real wires."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from drivers.platform import Platform
from drivers.registry import build_platform
from platform_daemon.engine.shot import RawShot, run_shot
from platform_daemon.settings import PlatformFile, apply_override, load_platform, locate, read_toml
from sequences.compiler import ShotPlan
from sim_backend.emulators.emulator import LabEmulator


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


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """One for all tests that leave it as it was."""
    made = Lab(tmp_path_factory.mktemp("lab"))
    yield made
    made.emulator.close()


@pytest.fixture(scope="class")
def lab_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Lab]]:
    """Labs with overrides of the emulator file."""
    made: list[Lab] = []

    def make(*overrides: str) -> Lab:
        made.append(Lab(tmp_path_factory.mktemp("lab"), *overrides))
        return made[-1]

    yield make
    for each in made:
        each.emulator.close()

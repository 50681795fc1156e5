"""Daemons and emulated labs as processes of their own, on free ports."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from platform_daemon.client import Client

START_S = 120.0
"""How long a process may take to start, s."""
_END_S = 60.0


class DidNotStart(RuntimeError):
    """A process did not start; the text is what it has said."""


@dataclass(frozen=True)
class RunningDaemon:
    """A daemon.

    Attributes:
        url: its address.
        data: its folder of recordings and results.
    """

    url: str
    data: Path

    def client(self) -> Client:
        """A client of it, which the caller closes."""
        return Client(self.url)


@dataclass(frozen=True)
class FaultyPlatform(RunningDaemon):
    """A daemon on the emulated lab.

    Attributes:
        control: host and port of the emulated lab's control socket.
    """

    control: tuple[str, int]

    def ask(self, do: str, **arguments: Any) -> Any:
        """A request to the emulated lab, as `ask("outputs")`; its result.  Raises ValueError if it refuses."""
        with socket.create_connection(self.control, 10) as link, link.makefile("rwb") as stream:
            stream.write(json.dumps({"do": do, **arguments}).encode() + b"\n")
            stream.flush()
            answer = json.loads(stream.readline())
        if not answer["ok"]:
            raise ValueError(answer["error"])
        return answer["result"]

    def inject(self, fault: str, *, device: str | None = None, **arguments: Any) -> None:
        """Let a fault strike: of a device's wire where a device is named, else of the world at the next shot.

        fault: as "adc_clip" or, of a wire, "timeout"; arguments: as the control socket takes them.  Raises ValueError
        for what the emulated lab refuses.
        """
        if device is not None:
            self.ask("wire_fault", kind=fault, device=device, **arguments)
            return
        try:
            self.ask("inject", kind=fault, **arguments)
        except ValueError as error:
            raise ValueError(f"{error} One of a wire, as timeout, also needs `device`.") from None


def _command(*words: str | Path) -> list[str]:
    return [sys.executable, "-m", "platform_daemon", *map(str, words)]


@contextmanager
def running_daemon(data: Path, options: Sequence[str | Path] = ()) -> Iterator[RunningDaemon]:
    """A daemon on a free port, which ends with the block.  Raises DidNotStart."""
    log = data.with_name(f"{data.name}.log")
    with log.open("w") as errors:
        words = _command("serve", "--port", "0", "--data", data, *options)
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=errors, text=True)
    try:
        yield RunningDaemon(_address(process, log), data)
    finally:
        _end(process)


def _address(process: subprocess.Popen[str], log: Path) -> str:
    """Raises DidNotStart."""
    assert process.stdout is not None
    for line in process.stdout:
        word = line.split()[-1] if line.split() else ""
        if word.startswith("http"):
            return word
    process.wait(_END_S)
    raise DidNotStart(f"the daemon ended with {process.returncode}: {log.read_text()[-2000:]}")


@contextmanager
def faulty_lab(folder: Path) -> Iterator[FaultyPlatform]:
    """The emulated lab, and a daemon on it, which end with the block.  Raises DidNotStart."""
    endpoints = folder / "endpoints.json"
    log = folder / "emulator.log"
    with log.open("w") as errors:
        words = _command("emulate", "--json", endpoints)
        emulator = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=errors, text=True)
    try:
        until_s = time.monotonic() + START_S
        while not endpoints.exists():
            if emulator.poll() is not None or time.monotonic() > until_s:
                raise DidNotStart(f"the emulated lab did not start: {log.read_text()[-2000:]}")
            time.sleep(0.05)
        control = json.loads(endpoints.read_text())["control"]
        options = ("--platform", "emulated", "--endpoints", endpoints)
        with running_daemon(folder / "data", options) as daemon:
            yield FaultyPlatform(daemon.url, daemon.data, (control["host"], control["port"]))
    finally:
        _end(emulator)


def _end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    try:
        process.communicate(timeout=_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()


def measure_to(path: Path, options: dict[str, Any], undeclared: Sequence[dict[str, Any]], seed: int) -> None:
    """Measure on the simulated platform into a file.  Raises ValueError with what the command has said."""
    words: list[str] = []
    for name, value in options.items():
        words += [f"--{name.replace('_', '-')}", *([] if value is True else [str(value)])]
    effects = ", ".join("{" + ", ".join(f"{k}={json.dumps(v)}" for k, v in each.items()) + "}" for each in undeclared)
    words += ["--set", f"backends.simulated.seed={seed}", "--set", f"backends.simulated.undeclared=[{effects}]"]
    made = subprocess.run(
        _command("measure", "--out", path, *words), capture_output=True, text=True, check=False, cwd=path.parent
    )
    if made.returncode != 0:
        raise ValueError(made.stderr.strip())

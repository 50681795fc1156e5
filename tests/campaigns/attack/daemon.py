"""The daemon that is attacked, as a process of its own."""

from __future__ import annotations

import os
import re
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx2

from tests.kit.command_line import COMMAND
from tests.kit.processes import child_of
from tests.kit.rest import finished


@dataclass
class Daemon:
    """Its process, its data folder, its ports, and a recording that it has made."""

    process: subprocess.Popen[str]
    data: Path
    port: int
    stop_port: int
    recording: str = ""

    def peak_mb(self) -> tuple[float, float, float]:
        """Most memory that the hardware process, the web process and the one for stop have held, MB."""
        hardware, web, stop = (_peak_mb(self._pid(name)) for name in ("hardware", "web", "stop"))
        return hardware, web, stop

    def forget_peak(self) -> None:
        """Measure the peaks from here on, where that is allowed."""
        for name in ("hardware", "web", "stop"):
            reset = Path(f"/proc/{self._pid(name)}/clear_refs")
            if os.access(reset, os.W_OK):
                reset.write_text("5")

    def _pid(self, name: str) -> int:
        return child_of(self.process.pid, "platform_daemon.processes", name)


def _peak_mb(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1e3  # type: ignore[index]


@contextmanager
def attacked(folder: Path, *options: str, rx_s: float) -> Iterator[Daemon]:
    """A daemon that has warmed up and holds one recording of one long shot."""
    folder.mkdir(exist_ok=True)
    command = [COMMAND, "serve", "--port", "0", "--data", folder / "data", *options]
    with (folder / "daemon.log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
        assert process.stdout is not None
        ports = [int(re.search(r":(\d+)", process.stdout.readline().partition("//")[2])[1]) for _ in "12"]  # type: ignore[index]
        try:
            daemon = Daemon(process, folder / "data", *ports)
            with httpx2.Client(base_url=f"http://127.0.0.1:{daemon.port}", timeout=120) as client:
                while client.get("/ready").status_code != 200:
                    time.sleep(0.1)
                shot = {"resonator": "thread", "window": None, "sequence": {"rx_s": rx_s, "pause_s": 10}}
                job = finished(client, client.post("/acquisitions", json=shot).headers["location"])
                daemon.recording = job["result"]["recording"]
            yield daemon
        finally:
            process.terminate()
            process.wait(60)

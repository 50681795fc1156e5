"""The daemon's processes on the emulated lab: how soon they are there, what they hold, how soon they are back."""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import httpx2

from tests.kit.command_line import wait_for
from tests.kit.emulator_process import emulator
from tests.kit.served import Served, served

SERIES = {"resonator": "jewel", "shots": 400, "sequence": {"rx_s": 0.3}}


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=5, help="how often each is measured")
    times = parser.parse_args().times
    with tempfile.TemporaryDirectory() as folder, emulator(Path(folder), "jewel") as (endpoints, _):
        options = "--platform", "emulated", "--endpoints", str(endpoints)
        starts = []
        for k in range(times):
            began = time.monotonic()
            with served(Path(folder) / f"start{k}", *options):
                starts.append(time.monotonic() - began)
        _row("from the command to the first answer", starts, "s")
        with served(Path(folder) / "data", *options) as daemon:
            wait_for(lambda: daemon.get("/ready").status_code == 200)
            location = daemon.post("/acquisitions", SERIES).headers["location"]
            wait_for(lambda: daemon.get(location).json()["progress"]["done"] >= 5)
            for name in ("hardware", "web", "stop"):
                _row(f"resident, {name} process", [_resident_mb(daemon, name)], "MB")
            _row("web process back after SIGKILL, in a series", [_back(daemon, "web") for _ in range(times)], "s")
            _row("stop process back after SIGKILL, in a series", [_stop_back(daemon) for _ in range(times)], "s")
            _row("hardware process back after SIGKILL, in a series", [_back(daemon, "hardware")], "s")


def _resident_mb(daemon: Served, name: str) -> float:
    pid = daemon.pid(name)
    return int(Path(f"/proc/{pid}/status").read_text().split("VmRSS:")[1].split()[0]) / 1000


def _back(daemon: Served, name: str) -> float:
    daemon.kill(name)
    began = time.monotonic()
    wait_for(lambda: _answers(daemon))
    return time.monotonic() - began


def _stop_back(daemon: Served) -> float:
    """Without stopping the series."""
    daemon.kill("stop")
    began = time.monotonic()
    assert httpx2.get(daemon.stop.replace("/stop", "/health"), timeout=30).status_code == 200
    return time.monotonic() - began


def _answers(daemon: Served) -> bool:
    try:
        return daemon.get("/platform").status_code == 200
    except httpx2.HTTPError:
        return False


def _row(what: str, values: list[float], unit: str) -> None:
    said = f"{statistics.median(values):.2f} {unit} (most {max(values):.2f}, n = {len(values)})"
    print(f"| {what} | {said} |", flush=True)


if __name__ == "__main__":
    main()

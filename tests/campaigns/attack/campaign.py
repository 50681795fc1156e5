"""Many at once against one daemon on the simulated platform: latency of /platform and /stop, peak memory.

`python -m tests.campaigns.attack.campaign --page docs/attack.md` writes the page; exit code 1: a bound does not hold.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import httpx2

from tests.campaigns.attack.load import Load, arguments
from tests.campaigns.attack.probe import Latencies, asked
from tests.kit.command_line import COMMAND
from tests.kit.data import ROOT
from tests.kit.rest import finished

STOP_S, PLATFORM_S, MEMORY_MB = 0.2, 0.1, 2000.0  # what is promised: p99 of /stop, of /platform with pollers, peak
EVERY_S = 0.1
PAGE = Path(__file__).with_name("page.txt")
BODIES = (1, 5, 20, 100)
SITUATIONS = {
    "nobody else": Load(),
    "50 pollers, 2 Hz each": Load(pollers=50),
    "bodies of 1, 5, 20 and 100 MB": Load(bodies_mb=BODIES),
    "1000 half-open connections": Load(half_open=1000),
    "45 heavy predictions at once": Load(predictions=45),
    "10 downloads at once": Load(downloads=10),
    "all of that together": Load(pollers=50, bodies_mb=BODIES, half_open=1000, predictions=45, downloads=10),
}


@dataclass
class Daemon:
    """A daemon as a process of its own: its ports, and a recording that it has made."""

    process: subprocess.Popen[str]
    port: int
    stop_port: int
    recording: str = ""

    def peak_mb(self) -> float:
        """Most memory that it has ever held, MB."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1e3  # type: ignore[index]

    def forget_peak(self) -> None:
        """Measure the peak from here on."""
        Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")


@dataclass
class Outcome:
    """What was measured in one situation."""

    name: str
    platform: Latencies
    stop: Latencies
    stop_main: Latencies
    peak_mb: float
    told: dict[str, int] = field(default_factory=dict)

    def broken(self) -> list[str]:
        """The bounds that do not hold."""
        found = []
        for what, latencies, bound in (
            ("/stop on its own port", self.stop, STOP_S),
            ("/stop on the main port", self.stop_main, STOP_S),
            ("/platform", self.platform, PLATFORM_S),
        ):
            if not latencies.at(0.99) < bound or latencies.refused:
                found.append(f"{self.name}: {what}: p99 {latencies.at(0.99):.3f} s, {latencies.refused} refused")
        if self.peak_mb > MEMORY_MB:
            found.append(f"{self.name}: {self.peak_mb:.0f} MB")
        return found


@contextmanager
def attacked(folder: Path, *, rx_s: float) -> Iterator[Daemon]:
    """A daemon that has warmed up and holds one recording of one long shot."""
    command = [COMMAND, "serve", "--port", "0", "--data", folder / "data"]
    with (folder / "daemon.log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
        assert process.stdout is not None
        ports = [int(re.search(r":(\d+)", process.stdout.readline().partition("//")[2])[1]) for _ in "12"]  # type: ignore[index]
        try:
            daemon = Daemon(process, *ports)
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


def measured(daemon: Daemon, name: str, load: Load, seconds: float) -> Outcome:
    """One situation."""
    if os.access(f"/proc/{daemon.process.pid}/clear_refs", os.W_OK):
        daemon.forget_peak()
    command = arguments(daemon.port, daemon.recording, seconds + 1, load)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as crowd, ThreadPoolExecutor(3) as pool:
        time.sleep(1.0)  # the crowd gathers
        until = time.monotonic() + seconds
        platform = pool.submit(asked, "GET", daemon.port, "/platform", until, EVERY_S)
        stop = pool.submit(asked, "POST", daemon.stop_port, "/stop", until, EVERY_S)
        stop_main = pool.submit(asked, "POST", daemon.port, "/stop", until, EVERY_S)
        latencies = platform.result(), stop.result(), stop_main.result()
        told = json.loads(crowd.communicate(timeout=120)[0])["told"]
    return Outcome(name, *latencies, daemon.peak_mb(), dict(sorted(told.items())))


def table(outcomes: Sequence[Outcome]) -> str:
    """Markdown; times in ms."""
    lines = [
        "| beside it | /platform p50, p99 | /stop on its own port p50, p99, max | /stop on the main port p50, p99, max "
        "| peak MB | what the others were answered |",
        "|---|---|---|---|---|---|",
    ]
    for o in outcomes:
        answers = ", ".join(f"{n} {what}" for what, n in o.told.items()) or "-"
        shown = [_ms(o.platform, 0.5, 0.99), _ms(o.stop, 0.5, 0.99, 1), _ms(o.stop_main, 0.5, 0.99, 1)]
        lines.append(f"| {o.name} | {' | '.join(shown)} | {o.peak_mb:.0f} | {answers} |")
    return "\n".join(lines)


def _ms(latencies: Latencies, *shares: float) -> str:
    text = ", ".join(f"{1e3 * latencies.at(share):.0f}" for share in shares)
    return text + (f" ({latencies.refused} refused)" if latencies.refused else "")


def page(outcomes: Sequence[Outcome], seconds: float, rx_s: float) -> str:
    """The document."""
    words = {
        "every_s": f"{EVERY_S:g}", "seconds": f"{seconds:g}", "rx_s": f"{rx_s:g}", "cores": os.cpu_count(),
        "stop_s": f"{STOP_S:g}", "platform_s": f"{PLATFORM_S:g}", "memory_mb": f"{MEMORY_MB:g}",
    }  # fmt: skip
    return PAGE.read_text().format(table=table(outcomes), **words)


def main() -> int:
    """0: all bounds hold."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.attack.campaign", description=__doc__)
    parser.add_argument("--seconds", type=float, default=20, help="for each situation")
    parser.add_argument("--rx-s", type=float, default=15, help="length of the shot that is downloaded, s")
    parser.add_argument("--only", action="append", choices=SITUATIONS, help="this situation; may be repeated")
    parser.add_argument("--page", type=Path, help="write the document")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, attacked(Path(folder), rx_s=given.rx_s) as daemon:
        outcomes = []
        for name in given.only or SITUATIONS:
            outcomes.append(measured(daemon, name, SITUATIONS[name], given.seconds))
            print(table(outcomes[-1:]).splitlines()[-1], flush=True)
    if given.page is not None:
        given.page.write_text(page(outcomes, given.seconds, given.rx_s))
    broken = [line for outcome in outcomes for line in outcome.broken()]
    print("\n".join(broken) or "all bounds hold")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())

"""A crowd against the main port of one daemon on the simulated platform: is the stop port answered in time, does the
memory stay bounded, and does a series lose a shot or get one late?

`python -m tests.campaigns.attack.campaign --page docs/evidence/attack.md` writes the page; exit code 1: a bound does
not hold.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from platform_daemon.core.guard.host_checks import priority
from tests.campaigns.attack.daemon import Daemon, attacked
from tests.campaigns.attack.load import Load, arguments
from tests.campaigns.attack.probe import Latencies, asked
from tests.campaigns.attack.series import LATE_S, REALTIME, Shots, series, series_table
from tests.kit.data import ROOT

STOP_S, PLATFORM_S, MEMORY_MB = 0.2, 0.1, 2000.0
"""What is promised: p99 of /stop on its own port, p99 of /platform beside users who poll it, peak of memory."""
EVERY_S = 0.05
HOLDS = "all bounds hold"
PAGE = Path(__file__).with_name("page.txt")
BODIES = (1, 5, 20, 100)
EVERYTHING = "all of that together"
POLLED = ("nobody else", "50 pollers, 2 Hz each")
"""Situations of ordinary use, in which /platform is bounded too."""
SITUATIONS = {
    POLLED[0]: Load(),
    POLLED[1]: Load(pollers=50),
    "bodies of 1, 5, 20 and 100 MB": Load(bodies_mb=BODIES),
    "1000 half-open connections": Load(half_open=1000),
    "45 heavy predictions at once": Load(predictions=45),
    "10 dry runs of 1000 shots that differ, at once": Load(dry_runs=10),
    "10 downloads at once": Load(downloads=10),
    EVERYTHING: Load(
        pollers=50, bodies_mb=BODIES, half_open=1100, predictions=45, dry_runs=5, downloads=10, diagnoses=2
    ),
}


@dataclass
class Outcome:
    """What was measured in one situation."""

    name: str
    platform: Latencies
    stop: Latencies
    peak_mb: tuple[float, float, float]
    told: dict[str, int] = field(default_factory=dict)

    def broken(self) -> list[str]:
        """The bounds that do not hold."""
        found = []
        if not self.stop.at(0.99) < STOP_S or self.stop.refused or not self.stop.seconds:
            found.append(f"{self.name}: /stop: p99 {self.stop.at(0.99):.3f} s, {self.stop.refused} refused")
        if self.name in POLLED and (not self.platform.at(0.99) < PLATFORM_S or self.platform.refused):
            found.append(f"{self.name}: /platform: p99 {self.platform.at(0.99):.3f} s, {self.platform.refused} refused")
        if max(self.peak_mb) > MEMORY_MB:
            found.append(f"{self.name}: {max(self.peak_mb):.0f} MB")
        return found


def measured(daemon: Daemon, name: str, load: Load, seconds: float) -> Outcome:
    """One situation."""
    daemon.forget_peak()
    command = arguments(daemon.port, daemon.recording, seconds + 1, load)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as crowd, ThreadPoolExecutor(2) as pool:
        time.sleep(1.0)  # the crowd gathers
        until = time.monotonic() + seconds
        platform = pool.submit(asked, "GET", daemon.port, "/platform", until, EVERY_S)
        stop = pool.submit(asked, "POST", daemon.stop_port, "/stop", until, EVERY_S)
        latencies = {"platform": platform.result(), "stop": stop.result()}
        told = json.loads(crowd.communicate(timeout=120)[0])["told"]
    return Outcome(name, **latencies, peak_mb=daemon.peak_mb(), told=dict(sorted(told.items())))


def table(outcomes: Sequence[Outcome]) -> str:
    """Markdown; times in ms."""
    lines = [
        "| beside it | /platform p50, p99 | /stop on its own port p50, p99, max "
        "| peak MB: hardware, web, stop | what the others were answered |",
        "|---|---|---|---|---|",
    ]
    for o in outcomes:
        answers = ", ".join(f"{n} {what}" for what, n in o.told.items()) or "-"
        peaks = ", ".join(f"{peak:.0f}" for peak in o.peak_mb)
        shown = [_ms(o.platform, 0.5, 0.99), _ms(o.stop, 0.5, 0.99, 1)]
        lines.append(f"| {o.name} | {' | '.join(shown)} | {peaks} | {answers} |")
    return "\n".join(lines)


def _ms(latencies: Latencies, *shares: float) -> str:
    text = ", ".join(f"{1e3 * latencies.at(share):.0f}" for share in shares)
    return text + (f" ({latencies.refused} refused)" if latencies.refused else "")


def page(outcomes: Sequence[Outcome], shots: Sequence[Shots], given: argparse.Namespace, load: float) -> str:
    """The document; load: of the computer before."""
    words = {
        "every_s": f"{EVERY_S:g}", "seconds": f"{given.seconds:g}", "rx_s": f"{given.rx_s:g}", "cores": os.cpu_count(),
        "stop_s": f"{STOP_S:g}", "platform_s": f"{PLATFORM_S:g}", "memory_mb": f"{MEMORY_MB:g}",
        "late_s": f"{LATE_S:g}", "priority": priority().found, "load": load, "nice": os.nice(0),
        "broken": "\n".join(broken(outcomes, shots)), "arguments": " ".join(sys.argv[1:]),
    }  # fmt: skip
    return PAGE.read_text().format(table=table(outcomes), series=series_table(shots), **words)


def broken(outcomes: Sequence[Outcome], shots: Sequence[Shots]) -> list[str]:
    """Lines on the bounds that do not hold, or that all do."""
    return [line for each in (*outcomes, *shots) for line in each.broken()] or [HOLDS]


def main() -> int:
    """0: all bounds hold."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.attack.campaign", description=__doc__)
    parser.add_argument("--seconds", type=float, default=10, help="for each situation")
    parser.add_argument("--rx-s", type=float, default=15, help="length of the shot that is downloaded, s")
    parser.add_argument("--shots", type=int, default=200, help="of each series in real time")
    parser.add_argument("--page", type=Path, help="write the document")
    given, load = parser.parse_args(), os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder, attacked(Path(folder), rx_s=given.rx_s) as daemon:
        outcomes = []
        for name in SITUATIONS:
            outcomes.append(measured(daemon, name, SITUATIONS[name], given.seconds))
            print(table(outcomes[-1:]).splitlines()[-1], flush=True)
    # POST /stop would end a series: it has a daemon of its own, and nobody stops it.
    with tempfile.TemporaryDirectory() as folder, attacked(Path(folder), *REALTIME, rx_s=2.0) as daemon:
        shots = [series(daemon, name, SITUATIONS[name], given.shots) for name in (POLLED[0], EVERYTHING)]
        print(series_table(shots), flush=True)
    if given.page is not None:
        given.page.write_text(page(outcomes, shots, given, load))
    said = broken(outcomes, shots)
    print("\n".join(said))
    return 0 if said == [HOLDS] else 1


if __name__ == "__main__":
    sys.exit(main())

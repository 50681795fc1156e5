"""A series in real time beside a crowd: is a shot refused, and does one come late?

The series is started before the crowd comes, and its end is read from the data folder: where the crowd takes all
connections of the main port, nobody else is answered there.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import httpx2

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.data_folder import data_paths
from platform_daemon.core.recordings.reader import open_recording
from tests.campaigns.attack.daemon import Daemon
from tests.campaigns.attack.load import Load, arguments
from tests.kit.data import ROOT

REALTIME = ("--set", 'backends.simulated.clock.mode="realtime"')
LATE_S = 0.5  # longer between two shots than usual
PATIENCE_S = 600.0


@dataclass(frozen=True)
class Shots:
    """Of one series: how many were asked for, came and were good; why the others were not; seconds from shot to shot,
    ascending; peaks of the hardware process and of the web process."""

    name: str
    asked: int
    good: int
    refused: tuple[str, ...]
    apart_s: tuple[float, ...]
    peak_mb: tuple[float, float, float]

    def usual_s(self) -> float:
        """From one shot to the next, the median."""
        return self.apart_s[len(self.apart_s) // 2]

    def broken(self) -> list[str]:
        """The bounds that do not hold."""
        found = []
        if self.refused or self.good != self.asked:
            said = f"{self.good} of {self.asked} shots are good, {len(self.refused)} refused"
            found.append(
                f"series, {self.name}: {said}" + "".join(f"; {reason}" for reason in sorted(set(self.refused)))
            )
        if self.apart_s[-1] > self.usual_s() + LATE_S:
            found.append(f"series, {self.name}: a shot came after {self.apart_s[-1]:.2f} s")
        return found


def series(daemon: Daemon, name: str, load: Load, shots: int) -> Shots:
    """A series of short shots on a daemon in real time; the crowd is there as long as it takes."""
    daemon.forget_peak()
    asked = {"resonator": "jewel", "shots": shots, "window": None, "sequence": {"rx_s": 0.3, "pause_s": 0.05}}
    command = arguments(daemon.port, daemon.recording, PATIENCE_S, load)
    address, records = f"http://127.0.0.1:{daemon.port}", JobRecords(data_paths(daemon.data).jobs)
    job = httpx2.post(f"{address}/acquisitions", json=asked, timeout=60).raise_for_status().json()["id"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, cwd=ROOT) as crowd:
        try:
            until = time.monotonic() + PATIENCE_S
            while not records.one(job).state.final:
                assert time.monotonic() < until
                time.sleep(1.0)
        finally:
            crowd.terminate()
    result = records.one(job).result
    frames = open_recording(daemon.data / "recordings" / result.file).frame_info
    begun = [frame.monotonic_s for frame in frames if frame.monotonic_s is not None]
    refused = tuple(frame.reason for frame in frames if frame.verdict != "good")
    apart = tuple(sorted(later - earlier for earlier, later in pairwise(begun)))
    return Shots(name, shots, len(frames) - len(refused), refused, apart, daemon.peak_mb())


def series_table(measured: Sequence[Shots]) -> str:
    """Markdown; times in ms."""
    lines = [
        "| beside it | shots good, refused | from shot to shot p50, max | peak MB: hardware, web, stop |",
        "|---|---|---|---|",
    ]
    for each in measured:
        peaks = ", ".join(f"{peak:.0f}" for peak in each.peak_mb)
        apart = f"{1e3 * each.usual_s():.0f}, {1e3 * each.apart_s[-1]:.0f}"
        lines.append(f"| {each.name} | {each.good} of {each.asked}, {len(each.refused)} | {apart} | {peaks} |")
    return "\n".join(lines)

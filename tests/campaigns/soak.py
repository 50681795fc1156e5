"""Many scheduled series at simulated speed, with fits, while others listen and poll.

python -m tests.campaigns.soak --shots 20000 --listeners 50 --page docs/evidence/soak.md

Each series is a start of one schedule.  After each: resident memory and open handles of the processes, and the trend of
the specimen is asked for; the last series must not take longer than the first.  Meanwhile listeners take all events,
and one client asks for the state of the platform.  At the end every listener must have had the same events in the order
of their numbers, without a gap, a shot and a fit for every shot; and the index, as it has grown, must be what a rebuild
makes of the recordings.
"""

from __future__ import annotations

import argparse
import json
import math
import sqlite3
import statistics
import sys
import tempfile
import threading
import time
from contextlib import closing
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import httpx2
import psutil

from platform_daemon.core.recordings.recording_index import INDEX
from platform_daemon.features.trends.indexed import update_index
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.data import ROOT
from tests.kit.served import Served, served

SERIES = 100  # shots
SPECIMEN = "soak"
PROCESSES = ("hardware", "web", "stop")
STATUS_S = 0.1
"""p99 of the state of the platform."""
SLOWER = 1.3
"""Times what a series took in the beginning."""
GROWTH_MB, HANDLES = 40.0, 10
"""So much more in the last quarter than in the second is too much; handles: more than at the least."""
HEAD = """# Soak

`make soak` (`python -m tests.campaigns.soak {arguments}`): series of {series}
shots (jewel, RX 0.6 s, fits in N50), each a start of one schedule, on the simulated platform as fast as it goes;
{listeners} listeners of `GET /events`, and a client that asks for the state of the platform 20 times a second.

| | |
|---|---|
"""


@dataclass
class Usage:
    """Of one process after each series: resident memory in MB, open handles."""

    resident_mb: list[float] = field(default_factory=list)
    handles: list[int] = field(default_factory=list)

    def look(self, pid: int) -> None:
        """Once."""
        process = psutil.Process(pid)
        self.resident_mb.append(process.memory_info().rss / 1e6)
        self.handles.append(process.num_fds())


@dataclass
class Found:
    """What a soak has brought."""

    shots: int
    listeners: int
    seconds: float = 0.0
    usage: dict[str, Usage] = field(default_factory=lambda: {name: Usage() for name in PROCESSES})
    status_s: list[float] = field(default_factory=list)
    out_of_order: int = 0
    """Listeners whose events were not those of all others in the order of their numbers."""
    missing: int = 0
    """Shots or fits of which some listener has not heard."""
    dropped: int = 0
    """Events that some listener was told it would not get."""
    failed: list[str] = field(default_factory=list)
    trend_s: list[float] = field(default_factory=list)
    """Until the trend was answered, after each series."""
    series_s: list[float] = field(default_factory=list)
    """What each series took."""
    fit_s: list[float] = field(default_factory=list)
    """From the event of a shot to that of its fit."""
    indexed: tuple[int, int] = (0, 0)
    """Lines of the index that differ from a rebuild, of how many."""

    def wrong(self) -> list[str]:
        """What must not be."""
        bounds = {
            "series did not end well": len(self.failed),
            "listeners had other events": self.out_of_order,
            "shots or fits were not told": self.missing,
            "events were dropped": self.dropped,
            "lines of the index are not those of a rebuild": self.indexed[0],
            "% slower in the last quarter than in the first": self.slower_percent(),
            "ms for the state of the platform, p99": max(0, round(1e3 * (self.percentile_s(0.99) - STATUS_S))),
        }
        found = [f"{count} {what}" for what, count in bounds.items() if count]
        for name, usage in self.usage.items():
            if self.growth_mb(name) > GROWTH_MB:
                found.append(f"{name} has grown by {self.growth_mb(name):.0f} MB")
            if max(usage.handles) > min(usage.handles) + HANDLES:
                found.append(f"{name} holds {min(usage.handles)} to {max(usage.handles)} handles")
        return found

    def percentile_s(self, share: float) -> float:
        """Of the answers to who asked for the state."""
        ordered = sorted(self.status_s)
        return ordered[min(len(ordered) - 1, math.ceil(share * len(ordered)) - 1)]

    def quarters_s(self) -> tuple[float, float]:
        """Median of what a series took in the first and in the last quarter."""
        quarter = max(1, len(self.series_s) // 4)
        return statistics.median(self.series_s[:quarter]), statistics.median(self.series_s[-quarter:])

    def slower_percent(self) -> int:
        """0: within what is allowed."""
        first, last = self.quarters_s()
        return round(100 * (last / first - 1)) if last > SLOWER * first else 0

    def growth_mb(self, name: str) -> float:
        """Resident memory of the last quarter of the series over that of the second, MB."""
        values = self.usage[name].resident_mb
        quarter = max(1, len(values) // 4)
        return statistics.median(values[-quarter:]) - statistics.median(values[quarter : 2 * quarter] or values)


class Listener(threading.Thread):
    """Keeps numbers and kinds of what it hears."""

    def __init__(self, address: str, ends: threading.Event) -> None:
        super().__init__(daemon=True)
        self.heard: list[tuple[int, str]] = []
        self.told: dict[str, dict[tuple[str, int], datetime]] = {"shot": {}, "fit": {}}
        """When a shot of a job, and its fit, happened."""
        self.dropped = 0
        self._address, self._ends = address, ends
        self.connected = threading.Event()

    def run(self) -> None:
        """Until the daemon ends."""
        try:
            with httpx2.stream("GET", f"{self._address}/events?kind=shot&kind=fit&kind=job", timeout=120) as answer:
                self.connected.set()
                kind = ""
                for line in answer.iter_lines():
                    if line.startswith("event: "):
                        kind = line[7:]
                    elif line.startswith("data: ") and kind == "dropped":
                        self.dropped += 1
                    elif line.startswith("data: ") and kind in self.told:
                        data = json.loads(line[6:])
                        what = data["what"]
                        self.told[kind][what["job"], what["shot"]] = datetime.fromisoformat(data["at"])
                    elif line.startswith("id: ") and kind != "dropped":
                        self.heard.append((int(line[4:]), kind))
        except httpx2.TransportError:
            self.connected.set()


def soak(folder: Path, shots: int, listeners: int) -> Found:
    """Raises AssertionError if a series cannot be started."""
    found, ends = Found(shots, listeners), threading.Event()
    with served(folder / "data") as daemon:
        everyone = [Listener(daemon.address, ends) for _ in range(listeners)]
        for each in everyone:
            each.start()
        assert all(each.connected.wait(60) for each in everyone)
        poller = threading.Thread(target=_poll, args=(daemon, found, ends))
        poller.start()
        began = time.monotonic()
        schedule = _schedule(daemon)
        for _ in range(shots // SERIES):
            _one(daemon, schedule, found)
        found.seconds = time.monotonic() - began
        time.sleep(2.0)
        ends.set()
        poller.join()
    for each in everyone:
        each.join(20)
    _judge(found, everyone)
    found.indexed = _index_against_rebuild(folder / "data" / "recordings")
    return found


def _schedule(daemon: Served) -> str:
    work = {"kind": "acquisition", "request": {**SHORT_JEWEL, "shots": SERIES, "window": "n50", "sample": SPECIMEN}}
    asked = {"name": "soak", "trigger": {"at": ["2099-01-01T00:00:00"]}, "work": work}  # all starts are by hand
    answer = daemon.post("/schedules", asked)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def _one(daemon: Served, schedule: str, found: Found) -> None:
    until = time.monotonic() + 30
    while (answer := daemon.post(f"/schedules/{schedule}/run", {})).status_code == 409:  # what ran is just ending
        assert time.monotonic() < until, answer.text
        time.sleep(0.1)
    assert answer.status_code == 202, answer.text
    began = time.monotonic()
    number = answer.json()["number"]
    while True:
        row = daemon.get(f"/schedules/{schedule}/ledger?after={number - 1}&limit=1").json()["items"][0]
        if row["state"] not in ("due", "started"):
            break
        time.sleep(0.2)
    found.series_s.append(time.monotonic() - began)
    if row["state"] not in ("run", "late"):
        found.failed.append(f"{row['state']}: {row['reason']}")
    began = time.monotonic()
    known = (200, 404) if not found.trend_s else (200,)  # the first series may not be in the index yet
    assert daemon.get(f"/specimens/{SPECIMEN}/trend").status_code in known
    found.trend_s.append(time.monotonic() - began)
    for name in PROCESSES:
        pid = daemon.pid(name)
        assert pid is not None
        found.usage[name].look(pid)


def _index_against_rebuild(recordings: Path) -> tuple[int, int]:
    update_index(recordings)
    with closing(sqlite3.connect(recordings / INDEX)) as grown:
        before = {*grown.iterdump()}
    update_index(recordings, rebuild=True)
    with closing(sqlite3.connect(recordings / INDEX)) as rebuilt:
        after = {*rebuilt.iterdump()}
    return len(before ^ after), len(before)


def _poll(daemon: Served, found: Found, ends: threading.Event) -> None:
    with httpx2.Client(base_url=daemon.address, timeout=30) as client:
        while not ends.wait(0.05):
            began = time.monotonic()
            assert client.get("/platform").status_code == 200
            found.status_s.append(time.monotonic() - began)


def _judge(found: Found, listeners: list[Listener]) -> None:
    first, told = listeners[0].heard, listeners[0].told
    found.fit_s = [(told["fit"][each] - told["shot"][each]).total_seconds() for each in told["fit"]]
    for each in listeners:
        numbers = [number for number, _ in each.heard]
        found.out_of_order += numbers != sorted(set(numbers)) or each.heard != first
        found.dropped += each.dropped
        for kind in ("shot", "fit"):
            found.missing += abs(found.shots // SERIES * SERIES - sum(k == kind for _, k in each.heard))


def page(found: Found, arguments: str) -> str:
    """The page."""
    rows = [
        ("shots, all with a fit", f"{found.shots // SERIES * SERIES} in {found.seconds:.0f} s"),
        ("series that did not end well", f"{len(found.failed)} {'; '.join(found.failed[:3])}"),
        ("listeners with events in another order, a gap or one twice", str(found.out_of_order)),
        ("shots and fits that a listener has not heard of", str(found.missing)),
        ("events that a listener was informed of as dropped", str(found.dropped)),
        ("from a shot to its fit", _times(found.fit_s)),
        ("a series, in the first and in the last quarter", " and ".join(f"{s:.1f} s" for s in found.quarters_s())),
        ("state of the platform, median", f"{1e3 * found.percentile_s(0.5):.0f} ms"),
        ("state of the platform, p99", f"{1e3 * found.percentile_s(0.99):.0f} ms of {len(found.status_s)}"),
        ("trend of the specimen, after each series", f"{max(found.trend_s):.1f} s at most, of {len(found.trend_s)}"),
        ("lines of the index that are not those of a rebuild", f"{found.indexed[0]} of {found.indexed[1]}"),
    ]
    for name, usage in found.usage.items():
        last, growth = usage.resident_mb[-1], found.growth_mb(name)
        rows += [
            (f"{name}: resident memory at the end", f"{last:.0f} MB, {growth:+.0f} MB since the second quarter"),
            (f"{name}: open handles at the end", f"{usage.handles[-1]}, {min(usage.handles)} to {max(usage.handles)}"),
        ]
    head = HEAD.format(arguments=arguments, series=SERIES, listeners=found.listeners)
    return head + "".join(f"| {what} | {value.strip()} |\n" for what, value in rows)


def _times(values: list[float]) -> str:
    ordered = sorted(values)
    last = ordered[min(len(ordered) - 1, math.ceil(0.99 * len(ordered)) - 1)]
    return f"{statistics.median(ordered):.2f} s (median), {last:.2f} s (p99), {ordered[-1]:.2f} s at most"


def main() -> int:
    """See the module; exit code 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shots", type=int, default=20_000)
    parser.add_argument("--listeners", type=int, default=50)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = soak(Path(folder), asked.shots, asked.listeners)
    text = page(found, f"--shots {asked.shots} --listeners {asked.listeners}")
    print(text)
    if asked.page is not None:
        (ROOT / asked.page).write_text(text)
    print(*found.wrong(), f"{len(found.wrong())} wrong", sep="\n")
    return int(bool(found.wrong()))


if __name__ == "__main__":
    sys.exit(main())

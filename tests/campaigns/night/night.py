"""The night itself, and what everybody has to tell in the morning."""

from __future__ import annotations

import json
import os
import shlex
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
import numpy as np

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import Recording
from tests.campaigns.crash.bench import Bench
from tests.campaigns.night.blows import Blow, strike, trip

EVERY_S = 8.0
SHOTS = 5
SERIES = {
    "resonator": "jewel",
    "shots": SHOTS,
    "sequence": {"rx_s": 0.4, "pause_s": 0.15},
    "window": "n50",
    "sample": "night",
}
FAILURES = 8
"""In a row, until the schedule switches itself off; what passes by itself makes fewer."""
_BETWEEN_S = 25.0  # on average
_CALL = "import sys; open(sys.argv[1], 'a').write(sys.stdin.read().replace(chr(10), ' ') + chr(10))"


@dataclass
class Night:
    """Of everybody: the ledger's rows, jobs by id, recordings by id, events in order, alarms that were called, those
    that stand, what was done to them, power that met the receiver; times in s since 1970."""

    began: float
    ended: float
    first_due: float
    rows: list[dict[str, Any]]
    jobs: dict[str, dict[str, Any]]
    recordings: dict[str, Recording]
    events: list[dict[str, Any]]
    called: list[dict[str, Any]]
    standing: list[str]
    blows: list[Blow] = field(default_factory=list)
    played: int = 0
    met: int = 0
    analyses: list[dict[str, Any]] = field(default_factory=list)
    names: dict[str, str] = field(default_factory=dict)
    """Of the schedules by id."""


def night(folder: Path, seconds: float, seed: int, *, last_trips: bool) -> Night:
    """So long, then a morning.  last_trips: in its last tenth the amplifier trips for good.  Raises AssertionError."""
    calls = folder / "called.jsonl"
    command = shlex.join([sys.executable, "-c", _CALL, str(calls)])
    bench = Bench(folder, seed, ("--alarm-command", command))
    try:
        bench.start()
        return _night(bench, folder, calls, seconds, seed, last_trips=last_trips)
    finally:
        bench.stop_daemon()
        bench.end()


def _night(bench: Bench, folder: Path, calls: Path, seconds: float, seed: int, *, last_trips: bool) -> Night:
    began = time.time()
    series = {"kind": "acquisition", "request": SERIES}
    plan = _add(bench, "night", EVERY_S, series, max_failures=FAILURES)
    fits = _add(bench, "fits", 45.0, {"kind": "fit", "specimen": "night", "window": "n50"}, max_failures=1000)
    blows = _blows(bench, seed, began + (0.9 if last_trips else 0.95) * seconds)
    if last_trips:
        blows.append(trip(bench))
    time.sleep(max(0.0, began + seconds - time.time()))
    _answered(bench, f"/schedules/{fits}/pause")
    _answered(bench, f"/schedules/{plan}/pause")
    _all_ended(bench, plan)
    _all_ended(bench, fits)
    rows, ended = _rows(bench, plan), time.time()
    jobs = {name: bench.get(f"/acquisitions/{name}") for name in _ids(bench, "/acquisitions")}
    found = sorted((folder / "data" / "recordings").glob("*.h5"))
    return Night(
        began=began,
        ended=ended,
        first_due=_seconds(rows[0]["due"]),
        rows=rows,
        jobs=jobs,
        recordings={path.stem: open_recording(path) for path in found},
        events=_events(bench),
        called=[json.loads(line) for line in calls.read_text().splitlines()] if calls.exists() else [],
        standing=[each["name"] for each in bench.get("/alarms")["items"] if each["cleared"] is None],
        blows=blows,
        played=bench.world.shots,
        met=len(bench.lab.violations()),
        analyses=_rows(bench, fits),
        names={plan: "the series", fits: "the fits by the calendar"},
    )


def _blows(bench: Bench, seed: int, until: float) -> list[Blow]:
    chance, blows = np.random.default_rng([seed, 0, 2]), list[Blow]()
    while True:
        pause_s = min(float(chance.exponential(_BETWEEN_S)), 5 * _BETWEEN_S)
        if time.time() + pause_s > until:
            return blows
        time.sleep(pause_s)
        blows.append(strike(bench, seed, len(blows)))
        print(len(blows), blows[-1].name, "struck" if blows[-1].struck else "met nothing", flush=True)


def _add(bench: Bench, name: str, every_s: float, work: dict[str, Any], max_failures: int) -> str:
    asked = {"name": name, "trigger": {"every_s": every_s}, "grace_s": 5.0, "max_failures": max_failures, "work": work}
    answer = bench.post("/schedules", asked)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def _answered(bench: Bench, path: str) -> None:
    """The web may just be on its way back."""
    until = time.monotonic() + 60
    while True:
        try:
            answer = bench.post(path, {})
        except httpx2.HTTPError:
            answer = None
        if answer is not None and answer.status_code < 300:
            return
        assert time.monotonic() < until, answer and answer.text
        time.sleep(0.2)


def _all_ended(bench: Bench, schedule: str) -> None:
    until = time.monotonic() + 120
    while any(row["state"] in ("due", "started") for row in _rows(bench, schedule)):
        assert time.monotonic() < until, "a row does not end"
        time.sleep(0.5)
    time.sleep(2.0)  # the last event is on its way


def _rows(bench: Bench, schedule: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    while True:
        after = found[-1]["number"] if found else 0
        page = bench.get(f"/schedules/{schedule}/ledger?after={after}&limit=1000")
        found += page["items"]
        if page["next"] is None:
            return found


def _ids(bench: Bench, path: str) -> list[str]:
    found: list[str] = []
    while True:
        page = [each["id"] for each in bench.get(f"{path}?limit=100{f'&after={found[-1]}' if found else ''}")["items"]]
        found += page
        if len(page) < 100:
            return found


def _events(bench: Bench) -> list[dict[str, Any]]:
    """All that the journal keeps."""
    found: list[dict[str, Any]] = []
    try:
        with httpx2.stream("GET", f"{bench.address}/events?after=0", timeout=5) as answer:
            for line in answer.iter_lines():
                if line.startswith("data: "):
                    found.append(json.loads(line[6:]))
    except httpx2.TimeoutException:  # nothing more comes
        pass
    return found


def _seconds(instant: str) -> float:
    from datetime import datetime

    return datetime.fromisoformat(instant).timestamp()


def cores() -> int:
    """That all of it shares."""
    return len(os.sched_getaffinity(0))

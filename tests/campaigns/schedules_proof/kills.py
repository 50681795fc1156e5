"""SIGKILL at random points: of the scheduler alone, at work as fast as it can, and of a daemon with its processes."""

from __future__ import annotations

import math
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.processes import NoSuchChild, child_of
from tests.kit.served import served
from tests.kit.stored_jobs import job_texts

CHILD = Path(__file__).with_name("scheduler_child.py")
EVERY_S = 2.0


@dataclass
class Survived:
    """Kills, due instants, rows by state, and what is wrong."""

    kills: int
    instants: int = 0
    states: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)


def scheduler_kills(folder: Path, kills: int, seed: int = 7) -> Survived:
    """The scheduler in a process of its own, that goes through simulated minutes; most kills meet it in a change of the
    ledger, or between a claim and its job."""
    chance, out = random.Random(seed), Survived(kills)
    for _ in range(kills):
        child = subprocess.Popen([sys.executable, str(CHILD), str(folder)], stdout=subprocess.PIPE)
        assert child.stdout is not None
        child.stdout.readline()  # it is at work
        try:
            child.wait(chance.uniform(0, 0.1))
        except subprocess.TimeoutExpired:
            child.kill()
        if child.wait() != -signal.SIGKILL:
            out.wrong.append(f"the scheduler ended by itself, with exit code {child.returncode}")
        child.stdout.close()
    rows = _rows(folder / "schedules.db")
    _check_instants(out, rows, 60.0)
    started = Counter((folder / "started").read_text().split())
    out.wrong += [f"{due} was started {n} times" for due, n in started.items() if n > 1]
    if len(started) < kills / 2:
        out.wrong.append(f"only {len(started)} starts in {kills} lives")
    jobs = {path.name for path in (folder / "jobs").iterdir()}
    told = {job for _, state, job, _ in rows if state in {"run", "late"}}
    out.wrong += [f"{job} is told to have run and never began" for job in told - jobs]
    out.wrong += [f"{job} began and is in no row" for job in jobs - {job for _, _, job, _ in rows}]
    out.wrong += [f"{due} was lost: {why}" for due, state, _, why in rows if state in {"failed", "missed", "skipped"}]
    return out


def daemon_kills(folder: Path, kills: int, seed: int = 7) -> Survived:
    """A daemon on the simulated platform with a series every 2 s: parent, hardware process or both are killed.

    A series that had begun is cut off and not begun again; all others are measured once.
    """
    chance, out, data = random.Random(seed), Survived(kills), folder / "data"
    ledger = data / "schedules.db"
    for number in range(kills):
        with served(data) as daemon:
            if number == 0:
                work = {"kind": "acquisition", "request": SHORT_JEWEL}
                asked: dict[str, Any] = {"name": "kills", "trigger": {"every_s": EVERY_S}, "work": work}
                daemon.post("/schedules", {**asked, "policy": "run_all", "grace_s": 86400, "max_failures": 1000})
            time.sleep(chance.uniform(0.0, 5.0))
            _kill(daemon.process.pid, chance.choice(("parent", "hardware", "both")))
            time.sleep(0.1)
    with served(data) as daemon:
        assert daemon.get("/schedules").json()["items"][0]["active"]
        now = time.time()
        wait_for(lambda: all(state not in {"due", "started"} for _, state, _, _ in _rows(ledger, now)), 600)
        rows = _rows(ledger, now)
    _check_instants(out, rows, EVERY_S)
    _check_recordings(out, rows, data)
    return out


def _kill(parent: int, who: str) -> None:
    try:
        hardware = child_of(parent, "platform_daemon.processes", "hardware")
    except NoSuchChild:
        hardware = parent
    for pid in {"parent": [parent], "hardware": [hardware], "both": [parent, hardware]}[who]:
        os.kill(pid, signal.SIGKILL)


def _rows(path: Path, until: float = math.inf) -> list[tuple[float, str, str | None, str | None]]:
    ledger = sqlite3.connect(path)
    try:
        query = "SELECT due, state, job, reason FROM rows WHERE due <= ? ORDER BY due"
        return ledger.execute(query, (until,)).fetchall()
    finally:
        ledger.close()


def _check_instants(out: Survived, rows: list[Any], every_s: float) -> None:
    out.instants, out.states = len(rows), Counter(state for _, state, _, _ in rows)
    for (a, *_), (b, *_) in pairwise(rows):
        if abs(b - a - every_s) > 1e-3:
            out.wrong.append(f"between {a} and {b} an instant is missing or doubled")


def _check_recordings(out: Survived, rows: list[Any], data: Path) -> None:
    recorded = {path.stem for path in (data / "recordings").glob("*.h5")}
    for due, state, job, why in rows:
        if state in {"run", "late"} and job not in recorded:
            out.wrong.append(f"{due} is told to have run, and has no recording")
        if state not in {"run", "late", "skipped"} and not why:
            out.wrong.append(f"{due} is {state} without a reason")
        if state in {"missed", "skipped"}:
            out.wrong.append(f"{due} was lost: {state}, {why}")
    jobs = [job for _, _, job, _ in rows if job]
    if len(set(jobs)) < len(jobs):
        out.wrong.append("two rows have one job")
    known = {job for _, _, job, _ in _rows(data / "schedules.db")}
    made = {job for job in job_texts(data) if job.startswith("acquisition-")}
    out.wrong += [f"{each} is in no row" for each in (recorded | made) - known]

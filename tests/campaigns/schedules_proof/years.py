"""Years of several schedules, whose clock leaps and which are asleep, restarted and killed; then the ledger is read."""

from __future__ import annotations

import json
import random
from collections import Counter
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from platform_daemon.features.schedules.launcher import JobOutcome
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.features.schedules.schema import LedgerRow, ScheduleRequest
from tests.campaigns.schedules_proof.oracle import due

T0 = datetime(2026, 1, 1, tzinfo=UTC).timestamp()
HOUR, DAY, YEAR = 3600.0, 86_400.0, 31_556_952.0
PLANS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "every 6 hours": ({"every_s": 21_600.0}, {"policy": "run_all", "grace_s": 7 * DAY}),
    "every 2.5 hours, jitter": ({"every_s": 9_000.0, "jitter_s": 600.0}, {"policy": "skip", "grace_s": 900.0}),
    "02:30 in Berlin": ({"cron": "30 2 * * *", "time_zone": "Europe/Berlin"}, {"grace_s": 4 * HOUR}),
    "hourly in Berlin": ({"cron": "15 * * * *", "time_zone": "Europe/Berlin"}, {}),
    "01:30 and 02:15 in New York": ({"cron": "15,30 1,2 * * *", "time_zone": "America/New_York"}, {"priority": 3}),
    "Lord Howe, half an hour of daylight saving": ({"cron": "0,30 */2 * * *", "time_zone": "Australia/Lord_Howe"}, {}),
    "workdays in St John's": ({"cron": "1 0 * * 1-5", "time_zone": "America/St_Johns"}, {"policy": "run_all"}),
    "month ends in Kathmandu": ({"cron": "45 23 28-31 * *", "time_zone": "Asia/Kathmandu"}, {}),
    "29 February": ({"cron": "0 12 29 2 *"}, {"grace_s": DAY}),
    "dates, some doubled or left out": (
        {"time_zone": "Europe/Berlin",
         "at": ["2026-03-29T02:30", "2026-10-25T02:30", "2027-03-28T02:00", "2030-01-01T00:00", "2033-10-30T02:59"]},
        {"grace_s": DAY},
    ),
}  # fmt: skip


class Owner:
    """A platform that does one thing at a time, each of `TAKES_S`; what it has done it knows through every restart."""

    TAKES_S = 240.0

    def __init__(self, years: Years) -> None:
        self._years = years
        self.began: dict[str, float] = {}

    def planned_s(self, work: Any) -> float:
        """See Launcher."""
        return self.TAKES_S

    def busy(self) -> bool:
        """See Launcher."""
        return bool(self.began) and self.outcome(next(reversed(self.began))).state == "running"

    def missing(self, work: Any, *, surely: bool) -> str | None:
        """See Launcher."""
        return None

    def new_id(self, work: Any) -> str:
        """See Launcher."""
        return f"acquisition-{len(self.began)}-{self._years.chance.random()}"

    def stops(self) -> int:
        return 0

    def launch(self, work: Any, job: str, stops: int) -> None:
        """See Launcher."""
        self._years.maybe_die()
        assert job not in self.began, "started twice"
        self.began[job] = self._years.work_s
        self._years.maybe_die()

    def outcome(self, job: str) -> JobOutcome:
        """See Launcher."""
        if job not in self.began:
            return JobOutcome("unknown")
        runs = self._years.work_s - self.began[job] < self.TAKES_S
        return JobOutcome("running") if runs else JobOutcome("done", None, job)


class _Died(BaseException):
    """The process is gone; nothing that it had in memory is left."""


@dataclass
class Told:
    """What was found: instants by schedule, rows by state, what struck how often, and what is wrong."""

    instants: dict[str, int] = field(default_factory=dict)
    states: Counter[str] = field(default_factory=Counter)
    struck: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)


class Years:
    """`now`: the clock of the computer; `work_s`: time as it passes for what works, which no clock changes."""

    LEAPS = (HOUR, -HOUR, DAY, -DAY, -10 * YEAR, -1.0)

    def __init__(self, folder: Path, years: float, seed: int, step_s: float) -> None:
        self._path, self._end_s, self._step_s = folder / "schedules.db", T0 + years * YEAR, step_s
        self.chance = random.Random(seed)
        self.now, self.work_s, self._wrong_by_s = T0, 0.0, 0.0
        self.told = Told()
        self._dying = 0.0
        self.owner = Owner(self)
        self.all = Schedules(self._path, self.owner, lambda: self.now)
        self.all.open()
        self._ids = {name: self._add(name) for name in PLANS}

    def _add(self, name: str) -> str:
        trigger, others = PLANS[name]
        work = {"kind": "acquisition", "request": {"resonator": "jewel", "shots": 1}}
        asked = {"name": name[:100], "trigger": trigger, "work": work, "max_failures": 1000, **others}
        return self.all.add(ScheduleRequest.model_validate_json(json.dumps(asked))).id

    def maybe_die(self) -> None:
        """Raises _Died, now and then."""
        if self.chance.random() < self._dying:
            self.told.struck["killed while it started something"] += 1
            raise _Died

    def run(self) -> Told:
        """Through all years, then the ledger against the oracle."""
        self._dying, furthest = 0.02, self.now
        while self.now < self._end_s:
            self._pass()
            furthest = max(furthest, self.now)
            try:
                self.all.step()
            except _Died:
                self._restart(orderly=False)
        self._dying = 0.0
        for _ in range(4):  # what runs comes to its end
            self._go(HOUR)
            self.all.step()
            furthest = max(furthest, self.now)
        for name, identifier in self._ids.items():
            self._check(name, list(self.all.page(identifier, limit=10**7).items), furthest)
        self.all.close()
        return self.told

    def _go(self, seconds: float) -> None:
        self.now += seconds
        self.work_s += seconds

    def _pass(self) -> None:
        """Some minutes, or more than that."""
        self._go(self.chance.uniform(0.2, 1.8) * self._step_s)
        if self._wrong_by_s and self.chance.random() < 0.2:  # somebody sets the clock right
            self.now, self._wrong_by_s = self.now - self._wrong_by_s, 0.0
        what = self.chance.random()
        if what < 0.002:
            leap = self.chance.choice(self.LEAPS)
            self.told.struck[f"clock leaps by {_shown(leap)}"] += 1
            self.now += leap
            self._wrong_by_s += leap
        elif what < 0.004:
            self.told.struck["asleep for hours or days"] += 1
            self._go(self.chance.choice((4 * HOUR, 9 * HOUR, 3 * DAY)))
        elif what < 0.008:
            self._restart(orderly=self.chance.random() < 0.5)

    def _restart(self, *, orderly: bool) -> None:
        self.told.struck["restarts" if orderly else "deaths"] += 1
        if orderly:
            self.all.close()
        self.all = Schedules(self._path, self.owner, lambda: self.now)
        self.all.open()

    def _check(self, name: str, rows: list[LedgerRow], furthest: float) -> None:
        expected = due(PLANS[name][0], T0, furthest)
        found = [datetime.fromisoformat(row.due).timestamp() for row in rows]
        for at, count in Counter(found).items():
            if count > 1:
                self.told.wrong.append(f"{name}: {at} is there {count} times")
        for at in sorted(set(expected) ^ set(found))[:20]:
            self.told.wrong.append(f"{name}: {at} is {'missing' if at in set(expected) else 'no instant'}")
        jobs = [row.job for row in rows if row.state in ("run", "late")]
        missing = [job for job in jobs if job not in self.owner.began]
        if len(set(jobs)) < len(jobs) or missing:
            self.told.wrong.append(f"{name}: {len(jobs) - len(set(jobs))} jobs twice, {len(missing)} never begun")
        waits = [row for row in rows if row.state in ("due", "started") and not _may_wait(row, self.now)]
        if waits:
            self.told.wrong.append(f"{name}: {len(waits)} rows are not final")
        lost = [row for row in rows if row.state in ("missed", "failed", "skipped", "late") and not row.reason]
        if lost:
            self.told.wrong.append(f"{name}: {len(lost)} rows without a reason")
        self.told.instants[name] = len(expected)
        self.told.states.update(row.state for row in rows)


def _may_wait(row: LedgerRow, now: float) -> bool:
    return datetime.fromisoformat(row.deadline).timestamp() >= now - DAY


def _shown(seconds: float) -> str:
    for name, unit in (("y", YEAR), ("d", DAY), ("h", HOUR)):
        if abs(seconds) >= unit:
            return f"{seconds / unit:+g} {name}"
    return f"{seconds:+g} s"

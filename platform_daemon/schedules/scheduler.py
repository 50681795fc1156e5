"""What is done at one moment: a step follows what runs, writes down what is due, and starts at most one work."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime

import structlog

from drivers.errors import InputError, PlatformError
from platform_daemon.schemas import AnyWorkRequest, ScheduleEvent

from .calendar import Calendar, jitter_s
from .launcher import JobOutcome, Launcher
from .ledger import ASKED_FOR, Kept, Ledger, Row
from .turns import with_priority, work_of

log = structlog.get_logger()
Tell = Callable[[ScheduleEvent], None]
ON_TIME_S = 5.0
"""A start is called late from then on, s after its instant and jitter."""
AT_ONCE = 5000
"""Instants of a schedule that one step writes down; the others follow with the next steps."""
AHEAD_S = 60.0
"""A clock that a time service sets back by less is not told of, s."""
_HELD_UP = "the daemon was away, its clock leapt, the platform was busy or its resonator not there, or the disk refused"
_CUT_OFF = "the daemon ended before its job was made"
LEAVE_THE_PLATFORM = frozenset({"fit", "diagnosis"})
"""Kinds of work that wait for each other only."""


def quiet(event: ScheduleEvent) -> None:
    """Nobody listens."""


class Scheduler:
    """Steps over a ledger.  tell: takes an event for every row that has changed; ends: the daemon is ending, and what
    becomes of its jobs from then on is for the next one to judge; rests: everything is being stopped, start nothing.

    A row is claimed together with the id of its job, before that job is made: after a death in between the job is
    unknown, and made then if it still may begin.
    """

    def __init__(
        self,
        ledger: Ledger,
        launcher: Launcher,
        tell: Tell = quiet,
        ends: Callable[[], bool] = lambda: False,
        rests: Callable[[], bool] = lambda: False,
    ) -> None:
        self._ledger, self._launcher, self._tell, self._ends, self._rests = ledger, launcher, tell, ends, rests
        self._coming: dict[str, tuple[float, Iterator[float], float | None]] = {}

    def step(self, now: float) -> bool:
        """Do what is to be done at `now`, s since 1970; is there more to do at once?  Raises StorageError."""
        everyone = {kept.identifier: kept for kept in self._ledger.schedules(removed=True)}
        for row in self._ledger.open_rows():
            if row.state == "started" and row.schedule in everyone:
                self._follow(row, everyone[row.schedule], now)
        schedules = {kept.identifier: kept for kept in self._ledger.schedules()}
        behind = [self._write_down(kept, now) for kept in schedules.values()]
        schedules = {kept.identifier: kept for kept in self._ledger.schedules()}
        self._sort_out(schedules, now, all_known=not any(behind))
        if any(behind):
            return True
        started = [self._start_one(schedules, now, beside=beside) for beside in (False, True)]
        return any(started)

    def rest(self, reason: str) -> None:
        """Start nothing more, of what was asked for by hand neither.  Raises StorageError."""
        for row in self._ledger.rest(reason):
            self._tell(_event(row, "skipped", reason, active=False))

    def remove(self, schedule: str) -> None:
        """It starts nothing any more; its ledger stays.  Raises StorageError."""
        waiting = [row for row in self._ledger.open_rows() if row.schedule == schedule and row.state == "due"]
        self._ledger.remove(schedule)
        for row in waiting:
            self._tell(_event(row, "skipped", "removed", active=False))

    def next_due(self, kept: Kept) -> float | None:
        """The first instant that is not in the ledger yet; None: there is none."""
        reached, coming, first = self._coming.get(kept.identifier, (None, iter(()), None))
        if reached != kept.reached:
            coming = self._instants(kept)
            first = next(coming, None)
            self._coming[kept.identifier] = kept.reached, coming, first
        return first

    def _instants(self, kept: Kept) -> Iterator[float]:
        """After those that are in the ledger; none of a calendar that is no more, as when a zone was given up."""
        try:
            return Calendar(kept.request, kept.created).after(kept.reached)
        except InputError as error:  # the others must go on
            log.error("schedule_never_due", schedule=kept.identifier, error=str(error))
            return iter(())

    def _write_down(self, kept: Kept, now: float) -> bool:
        """Instants up to now; are there more?"""
        first = self.next_due(kept)
        if first is None or first > now:
            return False
        _, coming, _ = self._coming.pop(kept.identifier)
        dues: list[tuple[float, float, float]] = []
        after = None
        for due in itertools.chain([first], coming):
            if due > now or len(dues) == AT_ONCE:
                after = due
                break
            begins = due + jitter_s(kept.identifier, due, kept.request.trigger.jitter_s)
            dues.append((due, begins, begins + kept.request.grace_s))
        self._ledger.reach(kept.identifier, dues, dues[-1][0])
        self._coming[kept.identifier] = dues[-1][0], coming, after
        return after is not None and after <= now

    def _sort_out(self, schedules: dict[str, Kept], now: float, *, all_known: bool) -> None:
        """End what is not to be started: off, past its deadline, or, once all that are due are known, by the policy of
        its schedule.  After years without the daemon millions are past it, which must not wait for each other."""
        rows = self._ledger.open_rows()
        running = {row.schedule for row in rows if row.state == "started"}
        ends: list[tuple[Row, str, str]] = []
        newest: dict[str, Row] = {}
        for row in rows:
            kept = schedules.get(row.schedule)
            if row.state != "due" or kept is None:
                continue
            if kept.off is not None and not row.asked and now >= row.begins:
                ends.append((row, "skipped", kept.off))  # nobody misses it, though the daemon was away
            elif now > row.deadline:
                ends.append((row, "missed", f"nothing could start it until its deadline, {_why(row)}"))
            elif row.asked or now < row.begins or not all_known:
                continue
            elif kept.request.policy == "skip" and row.schedule in running:
                ends.append((row, "skipped", "the one before it was still running"))
            elif kept.request.policy != "run_all" and row.schedule in newest:
                ends.append((newest[row.schedule], "skipped", "a later one was due before it could begin"))
                newest[row.schedule] = row
            else:
                newest[row.schedule] = row
        if ends:
            self._ledger.close_rows([(row.number, state, reason) for row, state, reason in ends])
            for row, state, reason in ends:
                self._tell(_event(row, state, reason, active=schedules[row.schedule].off is None))

    def _start_one(self, schedules: dict[str, Kept], now: float, *, beside: bool) -> bool:
        """Of those that need the platform, or (beside) of the others; may another one be started at once?"""
        works = {key: kept for key, kept in schedules.items() if _beside(kept) is beside}
        rows = [r for r in self._ledger.open_rows() if r.schedule in works]
        ready = [r for r in rows if r.state == "due" and r.begins <= now <= r.deadline]
        ready = [r for r in ready if not self._waits_for_hands(r, works[r.schedule])]
        if not ready or any(self._holds(r) for r in rows) or (not beside and self._launcher.busy()):
            return False
        row = min(ready, key=lambda r: (-works[r.schedule].request.priority, r.begins, r.number))
        kept = works[row.schedule]
        job = self._launcher.new_id(self._work(row, kept))
        if not self._ledger.claim(row, now, job):
            return True
        return not self._launched(replace(row, job=job), kept, now)

    def _holds(self, row: Row) -> bool:
        """Does its job keep others waiting?  One that is paused before it began does not."""
        return row.state == "started" and (row.job is None or self._launcher.outcome(row.job).state != "resting")

    def _work(self, row: Row, kept: Kept) -> AnyWorkRequest:
        asked = kept.request
        work = asked.work if asked.resonators is None else work_of(asked, self._ledger.turn(row))
        return with_priority(work, asked.priority)

    def _waits_for_hands(self, row: Row, kept: Kept) -> bool:
        """Must its resonator be mounted first, or an index be made?  Its row says so meanwhile.

        Nobody is told of the index, for which nobody can do anything.  Of a schedule for one resonator that one is
        taken to be there, unless another one is said to be.
        """
        in_turn = kept.request.resonators is not None
        missing = self._launcher.missing(self._work(row, kept), surely=in_turn)
        said = ASKED_FOR if missing is None and row.asked else missing
        if said != row.reason:
            self._ledger.note(row, said)
            if not _beside(kept):
                self._tell(_event(row, "due", missing, active=kept.off is None))
        return missing is not None

    def _launched(self, row: Row, kept: Kept, now: float) -> bool:
        assert row.job is not None
        stops = 0 if _beside(kept) else self._launcher.stops()
        if self._rests():  # asked after that: a stop rests schedules first, and then is counted
            return False
        try:
            self._launcher.launch(self._work(row, kept), row.job, stops)
        except PlatformError as error:
            if self._ends():  # nothing begins any more; it is claimed, and made by the next daemon
                return False
            log.error("scheduled_start_failed", schedule=kept.identifier, error=str(error))
            off = str(error) if isinstance(error, InputError) else None  # it would fail for ever
            self._failed(replace(row, job=None), kept, now, str(error), off)
            return False
        self._tell(_event(row, "started", row.reason, active=kept.off is None))
        return True

    def _follow(self, row: Row, kept: Kept, now: float) -> None:
        found = JobOutcome("unknown") if row.job is None else self._launcher.outcome(row.job)
        if self._ends():
            return
        if found.state == "unknown":
            if row.job is not None and (row.asked or kept.off is None) and now <= row.deadline:
                self._launched(row, kept, now)
            else:
                self._failed(replace(row, job=None), kept, now, kept.off or _CUT_OFF)
        elif found.state == "done":
            late = (row.late_s or 0.0) > ON_TIME_S
            reason = _HELD_UP if late else row.reason
            state = "late" if late else "run"
            self._ledger.end(row, state, now, reason, found.recording, None)
            self._tell(_event(row, state, reason, active=kept.off is None))
        elif found.state == "cancelled":
            self._failed(row, kept, now, "it was stopped", "it was stopped", found.recording)
        elif found.state == "failed":
            self._failed(row, kept, now, found.reason or "its job failed", recording=found.recording)

    def _failed(
        self, row: Row, kept: Kept, now: float, why: str, off: str | None = None, recording: str | None = None
    ) -> None:
        if off is None and kept.failures + 1 >= kept.request.max_failures:
            off = f"{kept.failures + 1} failures in a row, the last: {why}"
        self._ledger.end(row, "failed", now, why, recording, off)
        silent = "" if off is None else ". The schedule is switched off until somebody resumes it"
        self._tell(_event(row, "failed", f"{why.rstrip('.')}{silent}", active=kept.off is None))
        if off is not None:
            log.error("schedule_switched_off", schedule=row.schedule, reason=off)


def ahead_until(kept: Kept, now: float) -> float | None:
    """Until when all stands in its ledger already, because the clock has shown that once; None: it is not ahead."""
    if kept.reached <= now + AHEAD_S:
        return None
    if kept.request.start is None:
        return kept.reached
    with suppress(InputError):  # a zone that is no more: it starts nothing anyway
        if kept.reached > Calendar(kept.request, kept.created).start:
            return kept.reached
    return None


def _beside(kept: Kept) -> bool:
    return kept.request.work.kind in LEAVE_THE_PLATFORM


def _why(row: Row) -> str:
    waited = None if row.asked else row.reason
    return waited or _HELD_UP


def _event(row: Row, state: str, reason: str | None, *, active: bool) -> ScheduleEvent:
    due = datetime.fromtimestamp(row.due, UTC).isoformat()
    return ScheduleEvent(schedule=row.schedule, due=due, state=state, reason=reason, job=row.job, active=active)

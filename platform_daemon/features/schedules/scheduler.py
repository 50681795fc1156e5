"""One step of the schedules: end rows whose jobs have ended, add rows for instants that are due, start at most one job.

The time is an argument of a step, so a test can set it.  The order within a step matters: a row is claimed with the id
of its job, on the disk, before the job is made.  After a crash in between the job is unknown, and is made then if its
deadline has not passed; so no instant is started twice.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime

import structlog

from drivers.errors import InputError, PlatformError
from platform_daemon.core.schemas.events import ScheduleEvent
from platform_daemon.core.state.errors import RecordingInUse

from .calendar import Calendar, jitter_s
from .launcher import JobOutcome, Launcher
from .ledger import STARTED_BY_HAND, Ledger, Row, ScheduleRecord
from .rotation import with_priority, work_of
from .schema import AnyWorkRequest

log = structlog.get_logger()
Tell = Callable[[ScheduleEvent], None]
ON_TIME_S = 5.0
"""A start is late if it comes more than this after its instant and jitter, in s."""
AT_ONCE = 5000
"""Instants of a schedule that get rows in one step; the others follow in the next steps."""
MOST_MISSED = 20_000
"""If more instants than these have passed their deadlines, one row tells of all of them."""
AHEAD_S = 60.0
"""A clock that a time service sets back by less than this is not reported, in s."""
_HELD_UP = "the daemon was away, its clock leapt, the platform was busy or its resonator not there, or the disk refused"
_CUT_OFF = "the daemon ended before its job was made"
ANALYSES = frozenset({"fit", "diagnosis"})
"""Kinds of work that need no hardware, so that they wait for each other only."""


def quiet(event: ScheduleEvent) -> None:
    """Drop the event."""


class Scheduler:
    """Steps over a ledger.

    Args:
        ledger: the schedules and their rows.
        launcher: makes jobs, and knows what became of them.
        tell: takes an event for each row that has changed.
        is_ending: whether the daemon is ending; the next daemon judges what becomes of its jobs from then on.
        is_suspended: whether everything is being stopped, so that nothing may start.
    """

    def __init__(
        self,
        ledger: Ledger,
        launcher: Launcher,
        tell: Tell = quiet,
        *,
        is_ending: Callable[[], bool] = lambda: False,
        is_suspended: Callable[[], bool] = lambda: False,
    ) -> None:
        self._ledger = ledger
        self._launcher = launcher
        self._tell = tell
        self._is_ending = is_ending
        self._is_suspended = is_suspended
        # By schedule: the last instant that has a row, the instants after it, and the first of these.
        self._coming: dict[str, tuple[float, Iterator[float], float | None]] = {}

    def step(self, now: float) -> bool:
        """Do what is due at `now`, s since 1970; returns whether there is more to do at once.  Raises StorageError."""
        everyone = {record.id: record for record in self._ledger.schedules(removed=True)}
        for row in self._ledger.open_rows():
            if row.state == "started" and row.schedule in everyone:
                self._follow(row, everyone[row.schedule], now)
        schedules = {record.id: record for record in self._ledger.schedules()}
        behind = [self._write_down(record, now) for record in schedules.values()]
        schedules = {record.id: record for record in self._ledger.schedules()}
        self._sort_out(schedules, now, all_known=not any(behind))
        if any(behind):
            return True
        started = [self._start_one(schedules, now, analyses=analyses) for analyses in (False, True)]
        return any(started)

    def suspend(self, reason: str) -> None:
        """Switch all schedules off, and skip starts by hand that wait.  Raises StorageError."""
        for row in self._ledger.suspend(reason):
            self._tell(_event(row, "skipped", reason, active=False))

    def remove(self, schedule: str) -> None:
        """End a schedule for good; its rows stay.  Raises StorageError."""
        waiting = [row for row in self._ledger.open_rows() if row.schedule == schedule and row.state == "due"]
        self._ledger.remove(schedule)
        for row in waiting:
            self._tell(_event(row, "skipped", "removed", active=False))

    def next_due(self, record: ScheduleRecord) -> float | None:
        """The first instant that has no row yet; None: there is none."""
        reached, coming, first = self._coming.get(record.id, (None, iter(()), None))
        if reached != record.reached:
            coming = self._instants(record)
            first = next(coming, None)
            self._coming[record.id] = record.reached, coming, first
        return first

    def _instants(self, record: ScheduleRecord) -> Iterator[float]:
        """Instants that have no row yet; none if its time zone was abolished, so that they are unknown."""
        try:
            return Calendar(record.request, record.created).after(record.reached)
        except InputError as error:  # the others must continue
            log.error("schedule_never_due", schedule=record.id, error=str(error))
            return iter(())

    def _write_down(self, record: ScheduleRecord, now: float) -> bool:
        """Add rows for instants up to now; returns whether there are more of them."""
        first = self.next_due(record)
        if first is None or first > now:
            return False
        _, coming, _ = self._coming.pop(record.id)
        dues: list[tuple[float, float, float]] = []
        after = None
        for due in itertools.chain([first], coming):
            if due > now or len(dues) == AT_ONCE:
                after = due
                break
            begins = due + jitter_s(record.id, due, record.request.trigger.jitter_s)
            dues.append((due, begins, begins + record.request.grace_s))
        self._ledger.reach(record.id, dues, dues[-1][0])
        self._coming[record.id] = dues[-1][0], coming, after
        if after is None or after > now:
            return False
        self._pass_over(record, after, now, mean_gap_s=(after - dues[0][0]) / len(dues))
        return True

    def _pass_over(self, record: ScheduleRecord, first: float, now: float, *, mean_gap_s: float) -> None:
        """Tell in one row of all instants from `first` on whose deadlines have passed, if they are very many.

        A clock that leaps by ten years leaves millions, as many as a row a minute.
        """
        last = now - record.request.trigger.jitter_s - record.request.grace_s
        count = (last - first) / mean_gap_s
        if count <= MOST_MISSED:
            return
        state = "missed" if record.off is None else "skipped"
        until = datetime.fromtimestamp(last, UTC).isoformat(timespec="seconds")
        reason = f"this start and about {count:.2g} others until {until}: {record.off or _HELD_UP}"
        for row in self._ledger.pass_over(record.id, first, last, state, reason):
            self._tell(_event(row, state, reason, active=record.off is None))

    def _sort_out(self, schedules: dict[str, ScheduleRecord], now: float, *, all_known: bool) -> None:
        """End rows that must not start: their schedule is off, their deadline has passed, or by the policy.

        The policy is applied once all instants that are due have rows (`all_known`).  After years without the daemon
        millions of rows are past their deadlines, so these are ended in every step.
        """
        rows = self._ledger.open_rows()
        running = {row.schedule for row in rows if row.state == "started"}
        ends: list[tuple[Row, str, str]] = []
        newest: dict[str, Row] = {}
        for row in rows:
            record = schedules.get(row.schedule)
            if row.state != "due" or record is None:
                continue
            if record.off is not None and not row.by_hand and now >= row.begins:
                ends.append((row, "skipped", record.off))  # not missed, even if the daemon was away
            elif now > row.deadline:
                ends.append((row, "missed", f"nothing could start it until its deadline, {_why(row)}"))
            elif row.by_hand or now < row.begins or not all_known:
                continue
            elif record.request.policy == "skip" and row.schedule in running:
                ends.append((row, "skipped", "the one before it was still running"))
            elif record.request.policy != "run_all" and row.schedule in newest:
                ends.append((newest[row.schedule], "skipped", "a later one was due before it could begin"))
                newest[row.schedule] = row
            else:
                newest[row.schedule] = row
        if ends:
            self._ledger.close_rows([(row.number, state, reason) for row, state, reason in ends])
            for row, state, reason in ends:
                self._tell(_event(row, state, reason, active=schedules[row.schedule].off is None))

    def _start_one(self, schedules: dict[str, ScheduleRecord], now: float, *, analyses: bool) -> bool:
        """Start the row that comes first, of those that need the hardware or (analyses) of the others.

        Returns whether another one may be started at once.
        """
        works = {key: record for key, record in schedules.items() if _is_analysis(record) is analyses}
        rows = [r for r in self._ledger.open_rows() if r.schedule in works]
        ready = [r for r in rows if r.state == "due" and r.begins <= now <= r.deadline]
        ready = [r for r in ready if not self._waits_for_hands(r, works[r.schedule])]
        if not ready or any(self._holds(r) for r in rows) or (not analyses and self._launcher.busy()):
            return False
        row = min(ready, key=lambda r: (-works[r.schedule].request.priority, r.begins, r.number))
        record = works[row.schedule]
        job = self._launcher.new_id(self._work(row, record))
        if not self._ledger.claim(row, now, job):
            return True
        return not self._launched(replace(row, job=job), record, now)

    def _holds(self, row: Row) -> bool:
        """Whether its job keeps other rows waiting; a job that was paused before it began does not."""
        return row.state == "started" and (row.job is None or self._launcher.outcome(row.job).state != "resting")

    def _work(self, row: Row, record: ScheduleRecord) -> AnyWorkRequest:
        request = record.request
        work = request.work if request.resonators is None else work_of(request, self._ledger.starts_before(row))
        return with_priority(work, request.priority)

    def _waits_for_hands(self, row: Row, record: ScheduleRecord) -> bool:
        """Whether a person must mount its resonator first, or the index of recordings is being made.

        The reason is in the row meanwhile; no event is published for the index, because a person can do nothing about
        it.  A schedule for one resonator assumes that it is mounted unless another one is reported as mounted.
        """
        in_turn = record.request.resonators is not None
        missing = self._launcher.missing(self._work(row, record), surely=in_turn)
        said = STARTED_BY_HAND if missing is None and row.by_hand else missing
        if said != row.reason:
            self._ledger.note(row, said)
            if not _is_analysis(record):
                self._tell(_event(row, "due", missing, active=record.off is None))
        return missing is not None

    def _launched(self, row: Row, record: ScheduleRecord, now: float) -> bool:
        assert row.job is not None
        stops = 0 if _is_analysis(record) else self._launcher.stops()
        if self._is_suspended():  # read after `stops`: a stop suspends schedules first, and is counted then
            return False
        try:
            self._launcher.launch(self._work(row, record), row.job, stops)
        except PlatformError as error:
            if self._is_ending():  # the row is claimed, and the next daemon makes its job
                return False
            log.error("scheduled_start_failed", schedule=record.id, error=str(error))
            passing = isinstance(error, RecordingInUse)
            off = str(error) if isinstance(error, InputError) and not passing else None  # it would fail for ever
            self._failed(replace(row, job=None), record, now, str(error), off=off)
            return False
        self._tell(_event(row, "started", row.reason, active=record.off is None))
        return True

    def _follow(self, row: Row, record: ScheduleRecord, now: float) -> None:
        """End a started row once its job has ended; launch its job if a crash came between claim and launch."""
        found = JobOutcome("unknown") if row.job is None else self._launcher.outcome(row.job)
        if self._is_ending():
            return
        if found.state == "unknown":
            if row.job is not None and (row.by_hand or record.off is None) and now <= row.deadline:
                self._launched(row, record, now)
            else:
                self._failed(replace(row, job=None), record, now, record.off or _CUT_OFF)
        elif found.state == "done":
            late = (row.late_s or 0.0) > ON_TIME_S
            reason = _HELD_UP if late else row.reason
            state = "late" if late else "run"
            self._ledger.end(row, state, now, reason=reason, recording=found.recording, off=None)
            self._tell(_event(row, state, reason, active=record.off is None))
        elif found.state == "cancelled":
            self._failed(row, record, now, "it was stopped", off="it was stopped", recording=found.recording)
        elif found.state == "failed":
            self._failed(row, record, now, found.reason or "its job failed", recording=found.recording)

    def _failed(
        self,
        row: Row,
        record: ScheduleRecord,
        now: float,
        why: str,
        *,
        off: str | None = None,
        recording: str | None = None,
    ) -> None:
        if off is None and record.failures + 1 >= record.request.max_failures:
            off = f"{record.failures + 1} failures in a row, the last: {why}"
        self._ledger.end(row, "failed", now, reason=why, recording=recording, off=off)
        silent = "" if off is None else ". The schedule is suspended until it is resumed"
        self._tell(_event(row, "failed", f"{why.rstrip('.')}{silent}", active=record.off is None))
        if off is not None:
            log.error("schedule_switched_off", schedule=row.schedule, reason=off)


def ahead_until(record: ScheduleRecord, now: float) -> float | None:
    """Until when all instants have rows already, because the clock was ahead once; None: it was not."""
    if record.reached <= now + AHEAD_S:
        return None
    if record.request.start is None:
        return record.reached
    with suppress(InputError):  # its time zone was abolished, so it starts nothing
        if record.reached > Calendar(record.request, record.created).start:
            return record.reached
    return None


def _is_analysis(record: ScheduleRecord) -> bool:
    return record.request.work.kind in ANALYSES


def _why(row: Row) -> str:
    waited = None if row.by_hand else row.reason
    return waited or _HELD_UP


def _event(row: Row, state: str, reason: str | None, *, active: bool) -> ScheduleEvent:
    due = datetime.fromtimestamp(row.due, UTC).isoformat()
    return ScheduleEvent(schedule=row.schedule, due=due, state=state, reason=reason, job=row.job, active=active)

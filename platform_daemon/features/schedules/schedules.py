"""The schedules of a data folder, and the thread that carries them out.

The thread opens the ledger and then steps every second.  Where the disk refuses to open the ledger, the thread tries
again every second; a damaged ledger is not tried again.  Meanwhile all methods raise that error, and everything that is
started by hand continues.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from secrets import token_hex

import structlog

from drivers.errors import DeviceStateError, InputError, PlatformError
from platform_daemon.core.state.database import DamagedDatabase
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.flag_file import FlagFile

from .calendar import Calendar, cron_in_words
from .launcher import Launcher
from .ledger import Ledger, ScheduleRecord
from .rotation import works
from .scheduler import ANALYSES, Scheduler, Tell, ahead_until, quiet
from .schema import LedgerPage, LedgerRow, Schedule, ScheduleRequest
from .shown import iso, iso_or_none, shown_row, unreadable

log = structlog.get_logger()
_STEP_S = 1.0
_BY_HAND_S = 3600.0  # a start by hand waits so long for the hardware
_PATIENCE_S = 0.05  # a stop is answered within 0.2 s
_STOPPED_BEFORE = "everything was stopped, before the daemon was started again"


class UnknownSchedule(InputError):
    """No schedule has that id."""

    title = "Unknown schedule"
    http_status = 404


def suspension_flag(path: Path) -> FlagFile:
    """The flag of the ledger at `path` that all its schedules are to be paused before anything starts."""
    return FlagFile(path.with_suffix(".rest"))


class Schedules:
    """The schedules of the ledger at `path`, which `open` or `start` opens.

    Args:
        path: of the ledger, which is made if it does not exist.
        launcher: makes the jobs.
        clock: returns the time in s since 1970.
        tell: takes an event for each row that has changed.

    All methods but `start`, `suspend`, `pause_all`, `stop_starting` and `close` raise StorageError while the ledger is
    not open.

    Example:
        >>> schedules = Schedules(data / "schedules.db", launcher)
        >>> schedules.start()
        >>> schedules.add(ScheduleRequest(name="nightly", trigger={"cron": "0 22 * * *"}, work=work))
    """

    def __init__(
        self, path: Path, launcher: Launcher, clock: Callable[[], float] = time.time, tell: Tell = quiet
    ) -> None:
        self._path = path
        self._launcher = launcher
        self._clock = clock
        self._tell = tell
        self._flag = suspension_flag(path)
        self._lock = threading.Lock()  # of the ledger
        self._open_ledger: Ledger | None = None
        self._open_scheduler: Scheduler | None = None
        self._refusal = StorageError("the schedules are being opened", remedy="repeat the request in some seconds")
        self._ended = threading.Event()
        self._closed = False
        self._thread: threading.Thread | None = None
        self._said = ""  # the last error that was logged
        self._to_pause: str | None = None  # why all schedules are to be paused, until that is in the ledger

    def open(self) -> None:
        """Open the ledger.  Raises StorageError, DamagedDatabase."""
        try:
            ledger = Ledger(self._path)  # without the lock, so that calls meanwhile are refused at once
        except StorageError as error:
            self._refusal = error
            raise
        scheduler = Scheduler(
            ledger,
            self._launcher,
            self._tell,
            is_ending=self._ended.is_set,
            is_suspended=lambda: self._to_pause is not None,
        )
        with self._lock:
            if self._ended.is_set():
                ledger.close()
                return
            if self._to_pause is None and self._flag.is_set:
                self._to_pause = _STOPPED_BEFORE
            self._open_ledger = ledger
            self._open_scheduler = scheduler

    def start(self) -> None:
        """Open the ledger and step every second, in a thread, until `close`; errors are logged."""
        if self._try_open():
            self._thread = threading.Thread(target=self._work, name="schedules", daemon=True)
            self._thread.start()

    def step(self) -> None:
        """Do what is due now.  Raises StorageError, and then no job was made that the ledger does not name."""
        more = True
        while more and not self._ended.is_set():
            with self._lock:
                self._pause_suspended()
                more = self._scheduler.step(self._clock())

    def stop_starting(self) -> None:
        """Start nothing more, as of now, from any thread: outputs off must not wait for a step."""
        self._ended.set()

    def close(self) -> None:
        """Start nothing more, and close the ledger; running jobs continue.  Idempotent."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        with self._lock:
            try:
                if not self._closed:
                    self._pause_suspended()
            except StorageError:
                self._set_flag()
            self._closed = True
            if self._open_ledger is not None:
                self._open_ledger.close()

    def add(self, request: ScheduleRequest) -> Schedule:
        """Add a schedule.  Raises InputError: never due, more often than its work takes, not possible."""
        now = self._clock()
        calendar = self._checked(request, now)
        identifier = f"schedule-{datetime.fromtimestamp(now, UTC):%Y%m%dT%H%M%S}-{token_hex(3)}"
        reached = math.nextafter(max(now, calendar.start), -math.inf)
        record = ScheduleRecord(id=identifier, request=request, created=now, reached=reached)
        with self._lock:
            self._pause_suspended()  # an earlier stop does not concern a new schedule
            self._ledger.add(record)
            return self._shown(record)

    def list(self) -> tuple[Schedule, ...]:
        """All schedules but removed ones; last those of another version that this one cannot read."""
        with self._lock:
            return (*map(self._shown, self._ledger.schedules()), *map(unreadable, self._ledger.unreadable()))

    def get(self, identifier: str) -> Schedule:
        """One schedule.  Raises UnknownSchedule."""
        with self._lock:
            return self._found(identifier)

    def page(self, identifier: str, after: int = 0, limit: int = 100) -> LedgerPage:
        """Rows of a schedule, which may have been removed, with numbers above `after`.  Raises UnknownSchedule."""
        with self._lock:
            if all(each.id != identifier for each in self._ledger.unreadable(removed=True)):
                self._record(identifier, removed=True)
            rows = self._ledger.rows(identifier, after, limit + 1)
        shown = tuple(map(shown_row, rows[:limit]))
        more = f"/schedules/{identifier}/ledger?after={shown[-1].number}&limit={limit}" if len(rows) > limit else None
        return LedgerPage(items=shown, next=more)

    def pause(self, identifier: str) -> Schedule:
        """Skip all starts that become due; a running job continues.  Raises UnknownSchedule."""
        return self._switched(identifier, "paused")

    def resume(self, identifier: str) -> Schedule:
        """Start again what is due from now on.  Raises UnknownSchedule.

        Where the clock had been ahead, the instants that it showed and that are still to come are due once more; an
        instant whose job had begun is not repeated.
        """
        self._step_past(identifier)
        with self._lock:
            now = self._clock()
            if ahead_until(self._record(identifier), now) is not None:
                count = self._ledger.go_back(identifier, now)
                log.warning("schedule_set_back", schedule=identifier, instants=count)
        return self._switched(identifier, None)

    def suspend(self, reason: str) -> None:
        """Start nothing more, as of now; `pause_all` or the next step pauses all schedules in the ledger."""
        self._to_pause = reason

    def pause_all(self, reason: str) -> StorageError | None:
        """Pause all schedules because everything is being stopped; each is resumed by a person.

        Never raises and does not wait for a step, because a stop must not wait.  Returns the error if the ledger could
        not be written yet; until it is, nothing starts, not even after a restart.
        """
        self.suspend(reason)
        if not self._lock.acquire(timeout=_PATIENCE_S):
            return self._set_flag()
        try:
            if self._closed:
                return self._set_flag()
            self._pause_suspended()
        except StorageError as error:
            log.error("schedules_not_paused", error=str(error))
            self._set_flag()
            return error
        finally:
            self._lock.release()
        return None

    def _set_flag(self) -> StorageError | None:
        """Let the next process pause the schedules, should this one die now; returns why that cannot be noted."""
        if self._to_pause is None:
            return None
        try:
            self._flag.set()
        except StorageError as error:
            log.error("schedules_not_flagged", error=str(error))
            return error
        if self._to_pause is None:  # a step has paused them meanwhile
            self._flag.clear()
        return None

    def _pause_suspended(self) -> None:
        """Raises StorageError."""
        if self._to_pause is not None:
            self._scheduler.suspend(self._to_pause)
            self._to_pause = None
            self._flag.clear()

    @property
    def _ledger(self) -> Ledger:
        """Raises StorageError while it is not open."""
        if self._open_ledger is None:
            raise self._refusal.with_traceback(None)  # that of one error grows each time it is raised
        return self._open_ledger

    @property
    def _scheduler(self) -> Scheduler:
        """Raises StorageError while the ledger is not open."""
        if self._open_scheduler is None:
            raise self._refusal.with_traceback(None)
        return self._open_scheduler

    def remove(self, identifier: str) -> Schedule:
        """Remove a schedule; its rows stay.  Returns it as it is then: off for good.  Raises UnknownSchedule."""
        with self._lock:
            found = self._found(identifier)
            self._scheduler.remove(identifier)
        return found.model_copy(update={"active": False, "reason": "removed", "next_due": None, "ahead_until": None})

    def run(self, identifier: str) -> LedgerRow:
        """Start its work once, now.  Raises UnknownSchedule; DeviceStateError if the hardware is in use."""
        with self._lock:
            self._pause_suspended()  # this start is requested after that stop
            analysis = self._record(identifier).request.work.kind in ANALYSES
            if not analysis and self._launcher.busy():
                remedy = "wait until it has ended"
                raise DeviceStateError("the platform is busy", where=identifier, remedy=remedy)
            number = self._ledger.add_by_hand(identifier, self._clock(), self._clock() + _BY_HAND_S)
            return shown_row(self._ledger.rows(identifier, number - 1, 1)[0])

    def preview(self, request: ScheduleRequest, count: int = 10) -> tuple[str, ...]:
        """The first instants of a schedule that is not added, ISO 8601 in its zone.  Errors as in `add`."""
        now = self._clock()
        calendar = self._checked(request, now)
        dues = itertools.islice(calendar.after(max(now, calendar.start), inclusive=True), count)
        return tuple(calendar.shown(due) for due in dues)

    def _checked(self, request: ScheduleRequest, now: float) -> Calendar:
        """Errors as in `add`."""
        calendar = Calendar(request, now)
        planned, gap = self._longest_s(request), calendar.shortest_gap_s()
        if planned is not None and planned > gap:
            why = f"the work takes {planned:.4g} s at least, and is due again after {gap:.4g} s"
            remedy = "make it due less often, or the work shorter"
            raise InputError("the interval is shorter than the work", where="trigger", why=why, remedy=remedy)
        return calendar

    def _longest_s(self, request: ScheduleRequest) -> float | None:
        """Duration of its longest work, in s; None: unknown.  Raises InputError: not possible."""
        planned = [self._launcher.planned_s(work) for work in works(request)]
        return max((each for each in planned if each is not None), default=None)

    def _step_past(self, identifier: str) -> None:
        """Add rows for what was due while the schedule was off, as skipped: resuming must not start these."""
        with self._lock:
            self._record(identifier)
        self.step()

    def _switched(self, identifier: str, off: str | None) -> Schedule:
        with self._lock:
            self._pause_suspended()
            self._record(identifier)
            self._ledger.switch(identifier, off)
            return self._shown(self._record(identifier))

    def _record(self, identifier: str, *, removed: bool = False) -> ScheduleRecord:
        for record in self._ledger.schedules(removed=removed):
            if record.id == identifier:
                return record
        raise UnknownSchedule(f"no schedule {identifier!r}", where=identifier, remedy="list the schedules")

    def _found(self, identifier: str) -> Schedule:
        for each in self._ledger.unreadable():
            if each.id == identifier:
                return unreadable(each)
        return self._shown(self._record(identifier))

    def _shown(self, record: ScheduleRecord) -> Schedule:
        off = record.off or self._to_pause
        try:
            Calendar(record.request, record.created)
        except InputError as error:  # its time zone was abolished
            off = off or f"never due: {error}"
        return Schedule(
            id=record.id,
            request=record.request,
            created=iso(record.created),
            active=off is None,
            reason=off,
            failures=record.failures,
            next_due=iso_or_none(self._scheduler.next_due(record)),
            ahead_until=iso_or_none(ahead_until(record, self._clock())),
            cron_in_words=cron_in_words(record.request.trigger),
        )

    def _try_open(self) -> bool:
        """Whether the thread has something to do: the ledger is open, or may be later."""
        try:
            self.open()
        except StorageError as error:
            self._log_once("schedules_refused", error)
            return not isinstance(error, DamagedDatabase)
        return True

    def _work(self) -> None:
        while not self._ended.wait(_STEP_S):
            try:
                if self._open_ledger is None and not self._try_open():
                    return
                if self._open_ledger is not None:
                    self.step()
                    self._said = ""
            except PlatformError as error:  # tried again: a disk may be freed, a device may come back
                self._log_once("schedules_cannot_start", error)
            except Exception as error:  # the thread must outlive errors that were not foreseen
                log.error("schedules_step_failed", error=str(error), exc_info=True)

    def _log_once(self, event: str, error: PlatformError) -> None:
        if str(error) != self._said:
            self._said = str(error)
            log.error(event, error=self._said)

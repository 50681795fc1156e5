"""All schedules of a data folder: what is asked of them, and the thread that steps."""

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
from platform_daemon.schemas import LedgerPage, LedgerRow, Schedule, ScheduleRequest
from platform_daemon.store import Mark, StorageError

from .calendar import Calendar
from .launcher import Launcher
from .ledger import Kept, Ledger
from .scheduler import LEAVE_THE_PLATFORM, Scheduler, Tell, ahead_until, quiet
from .shown import iso, iso_or_none, shown_row, unreadable
from .turns import works

log = structlog.get_logger()
_STEP_S = 1.0
_BY_HAND_S = 3600.0  # a start by hand waits so long for the platform
_PATIENCE_S = 0.05  # a stop is to be answered within 0.2 s
_STOPPED_BEFORE = "everything was stopped, before the daemon was started again"


class UnknownSchedule(InputError):
    """No schedule has that id."""

    title = "Unknown schedule"


def rest_mark(path: Path) -> Mark:
    """Beside the ledger at `path`: all of them shall be paused before anything starts."""
    return Mark(path.with_suffix(".rest"))


class Schedules:
    """Schedules over the ledger at `path`.  clock: s since 1970; tell: takes events.  Raises StorageError for a damaged
    ledger."""

    def __init__(
        self, path: Path, launcher: Launcher, clock: Callable[[], float] = time.time, tell: Tell = quiet
    ) -> None:
        self._launcher, self._clock = launcher, clock
        self._ledger = Ledger(path)
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._scheduler = Scheduler(
            self._ledger, launcher, tell, self._ended.is_set, lambda: self._to_pause is not None
        )
        self._thread: threading.Thread | None = None
        self._error, self._closed = "", False
        self._mark = rest_mark(path)
        # Why all shall be paused, until the ledger has it.
        self._to_pause: str | None = _STOPPED_BEFORE if self._mark.stands else None

    def start(self) -> None:
        """Step every second, in a thread, until closed."""
        self._thread = threading.Thread(target=self._work, name="schedules", daemon=True)
        self._thread.start()

    def step(self) -> None:
        """Do what is to be done now.  Raises StorageError: nothing was started that the ledger does not say."""
        more = True
        while more and not self._ended.is_set():
            with self._lock:
                self._pause_rest()
                more = self._scheduler.step(self._clock())

    def stop_starting(self) -> None:
        """From any thread, at once: outputs off must not wait for a step."""
        self._ended.set()

    def close(self) -> None:
        """Start nothing more; what runs goes on.  Idempotent."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        with self._lock:
            try:
                if not self._closed:
                    self._pause_rest()
            except StorageError:
                self._marked()
            self._closed = True
            self._ledger.close()

    def add(self, request: ScheduleRequest) -> Schedule:
        """A new schedule.  Raises InputError: never due, no such zone, shorter than its work, work not possible."""
        now = self._clock()
        calendar = self._checked(request, now)
        identifier = f"schedule-{datetime.fromtimestamp(now, UTC):%Y%m%dT%H%M%S}-{token_hex(3)}"
        reached = math.nextafter(max(now, calendar.start), -math.inf)
        kept = Kept(identifier, request, now, reached, None, 0)
        with self._lock:
            self._pause_rest()  # a new one is not meant
            self._ledger.add(kept)
            return self._shown(kept)

    def list(self) -> tuple[Schedule, ...]:
        """All that were not removed; last those that another version has left and this one cannot read."""
        with self._lock:
            left = (unreadable(key, *why) for key, why in self._ledger.unreadable().items())
            return (*map(self._shown, self._ledger.schedules()), *left)

    def get(self, identifier: str) -> Schedule:
        """One of them.  Raises InputError."""
        with self._lock:
            return self._found(identifier)

    def page(self, identifier: str, after: int = 0, limit: int = 100) -> LedgerPage:
        """Rows of its ledger with numbers above `after`, of a removed one too.  Raises InputError."""
        with self._lock:
            if identifier not in self._ledger.unreadable(removed=True):
                self._kept(identifier, removed=True)
            rows = self._ledger.rows(identifier, after, limit + 1)
        return LedgerPage(rows=tuple(map(shown_row, rows[:limit])), more=len(rows) > limit)

    def pause(self, identifier: str) -> Schedule:
        """What is due from now on is skipped; what runs goes on.  Raises InputError."""
        return self._switched(identifier, "paused")

    def resume(self, identifier: str) -> Schedule:
        """Start again what is due from now on.  Raises InputError.

        Where the clock had been ahead, the instants that it showed and that are still to come are due once more; what
        had begun at one of them is not repeated.
        """
        self._step_past(identifier)
        with self._lock:
            now = self._clock()
            if ahead_until(self._kept(identifier), now) is not None:
                count = self._ledger.go_back(identifier, now)
                log.warning("schedule_set_back", schedule=identifier, instants=count)
        return self._switched(identifier, None)

    def rest(self, reason: str) -> None:
        """Start nothing more, as of now; `pause_all` or the next step pauses them."""
        self._to_pause = reason

    def pause_all(self, reason: str) -> StorageError | None:
        """Stop was pressed: nothing starts by itself until somebody resumes it.

        What comes back: why the ledger does not have it yet.  Nothing starts until it has, after a restart neither; a
        stop must not fail for it, nor wait for a step that plans.
        """
        self.rest(reason)
        if not self._lock.acquire(timeout=_PATIENCE_S):
            return self._marked()
        try:
            if self._closed:
                return self._marked()
            self._pause_rest()
        except StorageError as error:
            log.error("schedules_not_paused", error=str(error))
            self._marked()
            return error
        finally:
            self._lock.release()
        return None

    def _marked(self) -> StorageError | None:
        """Should the process die now, the next one pauses them."""
        try:
            self._mark.leave()
        except StorageError as error:
            log.error("schedules_not_marked", error=str(error))
            return error
        if self._to_pause is None:  # a step has paused them meanwhile
            self._mark.forget()
        return None

    def _pause_rest(self) -> None:
        """Raises StorageError."""
        if self._to_pause is not None:
            self._scheduler.rest(self._to_pause)
            self._to_pause = None
            self._mark.forget()

    def remove(self, identifier: str) -> Schedule:
        """It starts nothing any more; its ledger stays.  As it is now: off for good; raises InputError."""
        with self._lock:
            found = self._found(identifier)
            self._scheduler.remove(identifier)
        return found.model_copy(update={"active": False, "reason": "removed", "next_due": None, "ahead_until": None})

    def run(self, identifier: str) -> LedgerRow:
        """Start it once, now.  Raises InputError, DeviceStateError: the platform is busy."""
        with self._lock:
            self._pause_rest()  # it is asked for after that stop
            beside = self._kept(identifier).request.work.kind in LEAVE_THE_PLATFORM
            if not beside and self._launcher.busy():
                remedy = "wait until it has ended"
                raise DeviceStateError("the platform is busy", where=identifier, remedy=remedy)
            number = self._ledger.ask(identifier, self._clock(), self._clock() + _BY_HAND_S)
            return shown_row(self._ledger.rows(identifier, number - 1, 1)[0])

    def preview(self, request: ScheduleRequest, count: int = 10) -> tuple[str, ...]:
        """The first instants, ISO 8601 in the zone of the trigger; nothing is kept.  Errors as in `add`."""
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
        """Of its work with each of its resonators; None: nobody knows.  Raises InputError: it could not be done."""
        planned = [self._launcher.planned_s(work) for work in works(request)]
        return max((each for each in planned if each is not None), default=None)

    def _step_past(self, identifier: str) -> None:
        """Write down what was due while it was off, as skipped: resuming must not start it."""
        with self._lock:
            self._kept(identifier)
        self.step()

    def _switched(self, identifier: str, off: str | None) -> Schedule:
        with self._lock:
            self._pause_rest()
            self._kept(identifier)
            self._ledger.switch(identifier, off)
            return self._shown(self._kept(identifier))

    def _kept(self, identifier: str, *, removed: bool = False) -> Kept:
        for kept in self._ledger.schedules(removed=removed):
            if kept.identifier == identifier:
                return kept
        raise UnknownSchedule(f"no schedule {identifier!r}", where=identifier, remedy="list the schedules")

    def _found(self, identifier: str) -> Schedule:
        left = self._ledger.unreadable().get(identifier)
        return self._shown(self._kept(identifier)) if left is None else unreadable(identifier, *left)

    def _shown(self, kept: Kept) -> Schedule:
        off = kept.off or self._to_pause
        try:
            Calendar(kept.request, kept.created)
        except InputError as error:  # its zone was given up
            off = off or f"never due: {error}"
        return Schedule(
            identifier=kept.identifier,
            request=kept.request,
            created=iso(kept.created),
            active=off is None,
            reason=off,
            failures=kept.failures,
            next_due=iso_or_none(self._scheduler.next_due(kept)),
            ahead_until=iso_or_none(ahead_until(kept, self._clock())),
        )

    def _work(self) -> None:
        while not self._ended.wait(_STEP_S):
            try:
                self.step()
                self._error = ""
            except PlatformError as error:  # tried again: a disk may be freed, a device come back
                if str(error) != self._error:
                    self._error = str(error)
                    log.error("schedules_cannot_start", error=self._error)
            except Exception as error:  # the thread must outlive what nobody thought of
                log.error("schedules_step_failed", error=str(error), exc_info=True)

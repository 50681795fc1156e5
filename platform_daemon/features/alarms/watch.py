"""Follows the journal of events, and looks at the computer, in a thread."""

from __future__ import annotations

import shutil
import sqlite3
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
import structlog

from drivers.errors import PlatformError
from platform_daemon.core.schemas.events import AnyEvent, JobEvent
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.state.durable import write_file
from platform_daemon.core.state.event_journal import EventReader, KeptEvent, read_event

from .board import AlarmBoard
from .plans import Ask, look_at_schedules
from .rules import Rules

log = structlog.get_logger()
_EVENTS_EVERY_S, _COMPUTER_EVERY_S, _PAGE = 0.5, 30.0, 500
_GB = 1e9


@dataclass(frozen=True)
class Watched:
    """What is watched, and the limits beyond which an alarm is raised.

    folder: of the data; journal: of the events; seen: file with the number of the last event that was evaluated, so
    that none is missed while this process is down; disk_b, memory_b: less than this is free, bytes; clock_s: the
    time of day has leapt by more; idle_s: no job has begun for longer, None: no such alarm.
    """

    folder: Path
    journal: Path
    seen: Path
    disk_b: float = 2 * _GB
    memory_b: float = 0.3 * _GB
    clock_s: float = 5.0
    idle_s: float | None = None


class Watch:
    """Evaluates events and the computer in a thread, beginning with the events since the last evaluation.

    see: receives every event too; hardware: raises PlatformError while its owner does not answer; schedules: returns
    the schedules, None: there are none.
    """

    def __init__(
        self,
        watched: Watched,
        board: AlarmBoard,
        hardware: Callable[[], object],
        see: Callable[[AnyEvent], None] = lambda what: None,
        schedules: Ask | None = None,
    ) -> None:
        self._watched, self._board, self._hardware, self._see = watched, board, hardware, see
        self._schedules = schedules
        self._rules = Rules(board)
        self._ended = threading.Event()
        self._reader: EventReader | None = None
        self._last = 0
        self._begun_s, self._offset_s = time.monotonic(), time.time() - time.monotonic()
        self._thread = threading.Thread(target=self._work, name="alarms", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Idempotent."""
        self._ended.set()
        self._thread.join(5.0)

    def _work(self) -> None:
        looked_s, said = 0.0, ""
        while not self._ended.wait(_EVENTS_EVERY_S):
            try:
                self._read()
                if time.monotonic() - looked_s >= _COMPUTER_EVERY_S:
                    looked_s = time.monotonic()
                    self._look()
                said = ""
            except Exception as error:  # the thread must survive any unexpected error
                if str(error) != said:  # once, not twice a second
                    log.error("alarms_not_looked_at", error=str(error))
                said = str(error)
                self._forget_reader()
        self._forget_reader()

    def _forget_reader(self) -> None:
        if self._reader is not None:
            with suppress(sqlite3.Error):
                self._reader.close()
        self._reader = None

    def _read(self) -> None:
        if self._reader is None:
            self._reader = EventReader(self._watched.journal)
            self._last = self._last or self._seen(self._reader.newest())
            self._keep()
        found = self._reader.after(self._last, _PAGE)
        for each in found:
            self._last = each.id
            what = _typed(each)
            if what is None:
                continue
            if isinstance(what, JobEvent) and what.state is JobState.RUNNING:
                self._begun_s = time.monotonic()
            self._rules.see(what)
            self._see(what)
        if found:
            self._keep()

    def _keep(self) -> None:
        write_file(self._watched.seen, f"{self._last}\n".encode())

    def _seen(self, newest: int) -> int:
        """Number of the last event that was evaluated; `newest` if unknown, or if it is that of another journal."""
        try:
            last = int(self._watched.seen.read_text())
        except (OSError, ValueError):
            return newest
        return last if last <= newest else newest

    def _look(self) -> None:
        w = self._watched
        free, memory = shutil.disk_usage(w.folder).free, psutil.virtual_memory().available
        low = f"the disk of the data folder has {free / _GB:.1f} GB left, less than {w.disk_b / _GB:g} GB"
        self._stands("disk", free < w.disk_b, f"{low}. Remedy: free it; shots that do not fit are refused before power")
        little = f"the computer has {memory / _GB:.2f} GB of memory left"
        self._stands("memory", memory < w.memory_b, f"{little}. Remedy: end what takes it, or lower --worker-limit")
        offset_s = time.time() - time.monotonic()
        leap_s, self._offset_s = offset_s - self._offset_s, offset_s
        if abs(leap_s) > w.clock_s:
            remedy = "Remedy: let one time service set it; look at the ledger of each schedule"
            self._board.notice("clock", f"the clock of this computer has leapt by {leap_s:+.0f} s. {remedy}")
        else:
            self._board.clear("clock")
        coming = "" if self._schedules is None else look_at_schedules(self._board, self._schedules)
        idle_s = time.monotonic() - self._begun_s
        if w.idle_s is not None:
            idle = f"nothing has begun for {idle_s / 3600:.3g} h, longer than {w.idle_s / 3600:g} h"
            idle = f"{idle}, and {coming}" if coming else idle
            self._stands("idle", idle_s > w.idle_s, f"{idle}. Remedy: look at the schedules and at the queue")
        self._owner()

    def _owner(self) -> None:
        try:
            self._hardware()
        except PlatformError as error:
            self._board.notice("hardware", str(error))
        else:
            self._board.clear("hardware")

    def _stands(self, name: str, wrong: bool, what: str) -> None:
        if wrong:
            self._board.notice(name, what)
        else:
            self._board.clear(name)


def _typed(kept: KeptEvent) -> AnyEvent | None:
    """The event as its model; None: another version wrote it and this one cannot read it."""
    try:
        return read_event(kept).what
    except ValueError as error:
        log.warning("event_not_read", event=kept.id, error=str(error))
        return None

"""The alarms: at most one of each name is active; raising it again counts it and sends no second notification."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import structlog

from drivers.errors import DeviceStateError, InputError
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.events import AlarmEvent
from platform_daemon.core.state.database import Database
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.state_file import STATE_SCHEMA

from .schema import Alarm

log = structlog.get_logger()
MOST_CLEARED = 100
"""Alarms that are over and still listed."""
_KEEP_EVERY_S = 1.0  # a new text of an active alarm: ten thousand missed starts must not wait for as many writes


class UnknownAlarm(InputError):
    """No alarm has that name."""

    title = "Unknown alarm"
    http_status = 404


class AlarmBoard:
    """The alarms of a daemon, for any number of threads of one process.

    path: of the state file, where they are kept; tell: takes events; call: is called with each new alarm.  While the
    file cannot be written, alarms are kept until the process ends.
    """

    def __init__(
        self, path: Path, tell: Callable[[AlarmEvent], None], call: Callable[[Alarm], None] = lambda alarm: None
    ) -> None:
        self._path = path
        self._tell = tell
        self._call = call
        self._lock = threading.Lock()
        self._kept_s = 0.0
        self._file: Database | None = None
        self._alarms = {each.name: each for each in self._read()}

    def all(self) -> tuple[Alarm, ...]:
        """All alarms: first the active ones, the oldest of them first."""
        with self._lock:
            return tuple(sorted(self._alarms.values(), key=lambda each: (each.cleared is not None, each.since)))

    def standing(self) -> tuple[str, ...]:
        """Names of the active alarms."""
        return tuple(each.name for each in self.all() if each.cleared is None)

    def notice(self, name: str, what: str) -> None:
        """Raise the alarm, or count it if it is active already."""
        now = _now()
        with self._lock:
            before = self._alarms.get(name)
            if before is not None and before.cleared is None:
                again = {"what": what, "latest": now, "times": before.times + 1}
                self._alarms[name] = before.model_copy(update=again)
                if before.what != what and time.monotonic() - self._kept_s > _KEEP_EVERY_S:
                    self._keep()
                return
            alarm = Alarm(
                name=name, what=what, since=now, latest=now, times=1,
                cleared=None, acknowledged_by=None, acknowledged=None,
            )  # fmt: skip
            self._alarms[name] = alarm
            self._keep()
        log.error("alarm", alarm=name, what=what)
        self._tell(AlarmEvent(alarm=name, state="raised", what=what))
        self._call(alarm)

    def clear(self, name: str) -> None:
        """Clear the alarm if it is active."""
        with self._lock:
            before = self._alarms.get(name)
            if before is None or before.cleared is not None:
                return
            self._alarms[name] = before.model_copy(update={"cleared": _now()})
            self._forget_old()
            self._keep()
        log.info("alarm_cleared", alarm=name)
        self._tell(AlarmEvent(alarm=name, state="cleared", what=before.what))

    def acknowledge(self, name: str, by: str) -> Alarm:
        """Store who acknowledges the alarm; it stays active until it is cleared.

        Raises UnknownAlarm; InputError without a name; DeviceStateError if the alarm is over; StorageError, and then
        nothing is noted.
        """
        if not by.strip():
            raise InputError("no person is named", where="by", remedy="say who knows of it")
        with self._lock:
            before = self._alarms.get(name)
            if before is None:
                raise UnknownAlarm(f"no alarm is called {name!r}", where=name, remedy="GET /alarms lists them")
            if before.cleared is not None:
                remedy = "nothing is to be done"
                raise DeviceStateError("this alarm is over", where=name, why=f"since {before.cleared}", remedy=remedy)
            found = before.model_copy(update={"acknowledged_by": by.strip(), "acknowledged": _now()})
            self._alarms[name] = found
            try:
                self._write()
            except StorageError:
                self._alarms[name] = before
                raise
        self._tell(AlarmEvent(alarm=name, state="acknowledged", what=found.what, by=by.strip()))
        return found

    def _forget_old(self) -> None:
        over = sorted((each for each in self._alarms.values() if each.cleared), key=lambda each: each.cleared or "")
        for each in over[:-MOST_CLEARED]:
            del self._alarms[each.name]

    def _keep(self) -> None:
        try:
            self._write()
        except StorageError as error:  # the alarm is kept until this process ends
            log.error("alarms_not_kept", error=str(error))

    def _write(self) -> None:
        self._kept_s = time.monotonic()
        rows = [(each.name, to_json(each)) for each in self._alarms.values()]
        with self._database().transaction() as sql:
            sql.execute("DELETE FROM alarms")
            sql.executemany("INSERT INTO alarms (name, alarm) VALUES (?, ?)", rows)

    def _read(self) -> list[Alarm]:
        try:
            return [Alarm.model_validate_json(text) for (text,) in self._database().rows("SELECT alarm FROM alarms")]
        except (StorageError, ValueError) as error:  # what is still wrong is noticed again
            log.error("alarms_not_read", file=str(self._path), error=str(error))
            return []

    def _database(self) -> Database:
        """Raises StorageError."""
        if self._file is None:
            self._file = Database(self._path, STATE_SCHEMA)
        return self._file


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")

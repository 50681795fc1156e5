"""The alarms there are.  One of a name stands at a time; raising it again counts it and calls nobody."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import structlog

from drivers.errors import DeviceStateError, InputError
from platform_daemon.schemas import Alarm, AlarmEvent, Alarms, to_json
from platform_daemon.store import StorageError, write_file

log = structlog.get_logger()
MOST_CLEARED = 100
"""Alarms that are over and still shown."""
_KEEP_EVERY_S = 1.0  # of one that stands, other words: ten thousand missed starts must not wait for as many writes


class UnknownAlarm(InputError):
    """No alarm has that name."""

    title = "Unknown alarm"


class AlarmBoard:
    """For any number of threads of one process.

    path: where they are kept; tell: takes events; call: for each new one.
    """

    def __init__(
        self, path: Path, tell: Callable[[AlarmEvent], None], call: Callable[[Alarm], None] = lambda alarm: None
    ) -> None:
        self._path, self._tell, self._call = path, tell, call
        self._lock = threading.Lock()
        self._kept_s = 0.0
        self._alarms = {each.name: each for each in _read(path)}

    def all(self) -> tuple[Alarm, ...]:
        """Those that stand first, the oldest of them first."""
        with self._lock:
            return tuple(sorted(self._alarms.values(), key=lambda each: (each.cleared is not None, each.since)))

    def standing(self) -> tuple[str, ...]:
        """Names of those that stand."""
        return tuple(each.name for each in self.all() if each.cleared is None)

    def notice(self, name: str, what: str) -> None:
        """It is so now."""
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
        """It is over, if it stood."""
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
        """Somebody knows; it stands until it is over.

        Raises UnknownAlarm, InputError, DeviceStateError if it is, StorageError: nobody would know after a restart.
        """
        if not by.strip():
            raise InputError("nobody is named", where="by", remedy="say who knows of it")
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
        except StorageError as error:  # it stands all the same, until this process ends
            log.error("alarms_not_kept", error=str(error))

    def _write(self) -> None:
        self._kept_s = time.monotonic()
        write_file(self._path, to_json(Alarms(tuple(self._alarms.values())), indent=1).encode())


def _read(path: Path) -> tuple[Alarm, ...]:
    try:
        return Alarms.model_validate_json(path.read_bytes()).root
    except FileNotFoundError:
        return ()
    except (OSError, ValueError) as error:  # what stands is noticed again
        log.error("alarms_not_read", file=str(path), error=str(error))
        return ()


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")

"""The schedules of a data folder, however its disk was when the daemon began."""

from __future__ import annotations

import threading
from collections.abc import Callable

import structlog

from platform_daemon.store import Mark, StorageError

from .ledger_file import DamagedLedger
from .schedules import Schedules

log = structlog.get_logger()
_AGAIN_S = 1.0


class ScheduleKeeper:
    """Opens them; a disk that refuses is tried again, until it is `closed`, a damaged ledger is not.

    make: opens the ledger, raises StorageError; rest: mark that all of them shall rest, for whoever opens them next.
    """

    def __init__(self, make: Callable[[], Schedules], rest: Mark) -> None:
        self._make, self._rest = make, rest
        self._lock = threading.Lock()
        self._found: Schedules | None = None
        self._error: StorageError | None = None
        self._to_pause: str | None = None
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        """Once; what goes wrong is logged and told to who asks: all that is asked for by hand goes on."""
        if not self._opened():
            self._thread = threading.Thread(target=self._try_again, name="schedules-open", daemon=True)
            self._thread.start()

    def get(self) -> Schedules:
        """Raises StorageError while they cannot be opened."""
        if self._found is None:
            opening = StorageError("the schedules are being opened", remedy="ask again in some seconds")
            raise (self._error or opening).with_traceback(None)  # that of one grows each time it is raised
        return self._found

    def rest(self, reason: str) -> None:
        """They start nothing more, as of now; also those that are opened later."""
        with self._lock:
            found = self._found
            if found is None:
                self._to_pause = reason
        if found is not None:
            found.rest(reason)

    def pause_all(self, reason: str) -> StorageError | None:
        """See Schedules; of those that cannot be opened the next who opens them knows."""
        self.rest(reason)
        error = self._error
        if self._found is None:
            try:
                self._rest.leave()
            except StorageError as refused:
                error = refused
        return error if self._found is None else self._found.pause_all(reason)

    def stop_starting(self) -> None:
        """See Schedules."""
        self._ended.set()
        with self._lock:
            found = self._found
        if found is not None:
            found.stop_starting()

    def close(self) -> None:
        """See Schedules.  Idempotent."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        if self._found is not None:
            self._found.close()

    def _opened(self) -> bool:
        """Is there nothing more to try?"""
        try:
            found = self._make()
        except StorageError as error:
            if str(error) != str(self._error):  # once
                log.error("schedules_refused", error=str(error))
            self._error = error
            return isinstance(error, DamagedLedger)
        with self._lock:  # a stop meanwhile has told either us or them, and so has an end
            if self._to_pause is not None:
                found.rest(self._to_pause)
            if not self._ended.is_set():
                self._found = found
        if self._found is None:
            found.close()
        else:
            found.start()
        return True

    def _try_again(self) -> None:
        while not self._ended.wait(_AGAIN_S):
            if self._opened():
                return

"""Brings the index of the recordings up to date, and raises an alarm for each change of a specimen that stands."""

from __future__ import annotations

import threading
import time
from collections.abc import Container
from pathlib import Path
from typing import get_args

import structlog

from drivers.errors import PlatformError
from platform_daemon.alarms import AlarmBoard
from platform_daemon.analysis import indexed_specimens, indexed_trend, update_index
from platform_daemon.schemas import ChangeName

log = structlog.get_logger()
_LOOK_EVERY_S = 2.0
_REST = 9.0  # times as long as judging took


class TrendKeeper:
    """In a thread of its own, from now on.  folder: of the recordings; board: takes the alarms."""

    def __init__(self, folder: Path, board: AlarmBoard) -> None:
        self._folder, self._board = folder, board
        self._left, self._seen_ns = 0, -1
        self._changed: set[str] = set()
        self._next_s = 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="trends", daemon=True)
        self._thread.start()

    @property
    def behind(self) -> int:
        """Recordings that have still to be looked at."""
        return self._left

    def close(self) -> None:
        """Idempotent."""
        self._ended.set()
        self._thread.join(5.0)

    def _work(self) -> None:
        said = ""
        while not self._ended.wait(_LOOK_EVERY_S):
            try:
                self._look()
                self._judge_changed()
                said = ""
            except _Ended:
                return
            except Exception as error:  # whatever it is: one recording must not end the trends of all others
                if str(error) != said:  # once, not every two seconds
                    unforeseen = not isinstance(error, PlatformError | OSError)
                    log.error("trends_not_looked_at", error=str(error), exc_info=unforeseen)
                said = str(error)

    def _look(self) -> None:
        changed_ns = self._folder.stat().st_mtime_ns  # a recording appears, and goes, by its name
        if changed_ns == self._seen_ns:
            return
        found, _ = update_index(self._folder, self._told)
        self._changed |= found.specimens
        self._seen_ns = changed_ns

    def _judge_changed(self) -> None:
        begun_s = time.monotonic()
        if not self._changed or begun_s < self._next_s:
            return
        known = indexed_specimens(self._folder)
        while self._changed and not self._ended.is_set():
            specimen = self._changed.pop()
            if specimen in known:
                self.judge(specimen)
            else:  # nothing could ever end them: its recordings are gone
                self._clear(specimen, but=())
        # Years of a specimen take a second: recordings that come faster are judged together.
        self._next_s = time.monotonic() + _REST * (time.monotonic() - begun_s)

    def _told(self, n: int, of: int) -> None:
        self._left = of - n
        if self._ended.is_set():
            raise _Ended

    def judge(self, specimen: str) -> None:
        """Raise or clear its alarms.  Raises UnknownSpecimen, StorageError."""
        report = indexed_trend(self._folder, specimen)
        standing = {each.name: each for each in report.changes if each.stands}
        for name, change in standing.items():
            what = f"{specimen} since {change.since}: {change.what}. See GET /specimens/{specimen}/trend"
            self._board.notice(f"trend:{specimen}:{name}", what)
        self._clear(specimen, but=standing)

    def _clear(self, specimen: str, but: Container[str]) -> None:
        """Its alarms, by whole names: that of another specimen may begin with it."""
        for change in get_args(ChangeName.__value__):
            if change not in but:
                self._board.clear(f"trend:{specimen}:{change}")


class _Ended(Exception):
    """The process ends."""

"""Updates the index of the recordings, and raises an alarm for each persistent change of a specimen."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Container
from pathlib import Path
from typing import get_args

import structlog

from drivers.errors import PlatformError
from platform_daemon.core.recordings.recording_index import INDEX
from platform_daemon.core.schemas.text import same_name
from platform_daemon.features.alarms.board import AlarmBoard

from .indexed import indexed_specimens, indexed_trend, update_index
from .schema import ChangeName, TrendReport

log = structlog.get_logger()
_PERIOD_S = 2.0
_PATIENCE_S = 1.0  # a new recording is indexed in some 0.1 s; years of them are not waited for
_IDLE_FACTOR = 9.0  # pause after judging, in times of how long it took
KEPT_POINTS = 1000
"""Points of a report that is kept, the newest: what a picture shows."""
_KEPT_SPECIMENS = 8  # a report of 1000 points takes some 2 MB


class TrendKeeper:
    """A thread that works from now on.  folder: of the recordings; board: takes the alarms."""

    def __init__(self, folder: Path, board: AlarmBoard) -> None:
        self._folder = folder
        self._board = board
        self._left = 0
        self._seen_ns = -1
        self._files: frozenset[tuple[str, int]] | None = None
        self._looks = 0
        self._changed: set[str] = set()
        self._kept: dict[str, tuple[int, TrendReport]] = {}
        self._making = threading.Lock()
        self._next_s = 0.0
        self._ended = False
        self._wake = threading.Event()
        self._waiting: list[threading.Event] = []
        self._thread = threading.Thread(target=self._work, name="trends", daemon=True)
        self._thread.start()

    @property
    def behind(self) -> int:
        """Number of recordings that are not indexed yet."""
        return self._left

    def catch_up(self, timeout_s: float = _PATIENCE_S) -> None:
        """Wait until the recordings that are in the folder now are indexed, or for `timeout_s`.

        A client that has just measured then finds the recording with its first request.
        """
        try:
            if self._folder.stat().st_mtime_ns == self._seen_ns:
                return
        except OSError:  # the query says so
            return
        looked = threading.Event()
        self._waiting.append(looked)
        self._wake.set()
        looked.wait(timeout_s)

    def close(self) -> None:
        """Idempotent."""
        self._ended = True
        self._wake.set()
        self._thread.join(5.0)

    def _work(self) -> None:
        logged = ""
        # The first look is at once: an index that is made while the folder is empty never answers "being made".
        while not self._ended:
            waiting, self._waiting = self._waiting, []
            try:
                self._look()
                self._judge_changed()
                logged = ""
            except _Ended:
                return
            except Exception as error:  # whatever it is, one recording must not end the trends of all others
                if str(error) != logged:  # once, not every two seconds
                    unforeseen = not isinstance(error, PlatformError | OSError)
                    log.error("trends_not_looked_at", error=str(error), exc_info=unforeseen)
                logged = str(error)
            finally:
                for looked in waiting:
                    looked.set()
            self._wake.wait(_PERIOD_S)
            self._wake.clear()

    def _look(self) -> None:
        changed_ns = self._folder.stat().st_mtime_ns  # changes when a file is added or removed, the index's own too
        if changed_ns == self._seen_ns:
            return
        files = _files_in(self._folder)
        if files != self._files:
            found, _ = update_index(self._folder, self._on_progress)
            self._changed |= found.specimens
            self._looks += 1
            self._files = None if found.in_use else files
        self._seen_ns = -1 if self._files is None else changed_ns

    def _judge_changed(self) -> None:
        begun_s = time.monotonic()
        if not self._changed or begun_s < self._next_s:
            return
        known = indexed_specimens(self._folder)
        while self._changed and not self._ended:
            specimen = self._changed.pop()
            if specimen in known:
                self.judge(specimen)
            else:  # its recordings were removed: nothing else could clear its alarms
                self._clear(specimen, but=())
        # Years of a specimen take a second: recordings that come faster are judged together.
        self._next_s = time.monotonic() + _IDLE_FACTOR * (time.monotonic() - begun_s)

    def _on_progress(self, n: int, of: int) -> None:
        self._left = of - n
        if self._ended:
            raise _Ended

    def trend(self, specimen: str) -> TrendReport:
        """The trend with its newest KEPT_POINTS points, made once for as long as the folder is as it is.

        Raises UnknownSpecimen, StorageError.
        """
        with self._making:  # a page asks for the trend and for the specimen at once: both wait for one report
            looks, found = self._kept.get(specimen, (-1, None))
            return found if found is not None and looks == self._looks else self._make(specimen)

    def _make(self, specimen: str) -> TrendReport:
        looks = self._looks
        report = indexed_trend(self._folder, specimen, newest=KEPT_POINTS)
        self._kept.pop(specimen, None)
        if self._files is not None:  # else files are still to be read
            self._kept = {**dict(list(self._kept.items())[1 - _KEPT_SPECIMENS :]), specimen: (looks, report)}
        return report

    def judge(self, specimen: str) -> None:
        """Raise or clear the alarms of a specimen.  Raises UnknownSpecimen, StorageError."""
        specimen = same_name(specimen)
        with self._making:
            report = self._make(specimen)
        persistent = {each.name: each for each in report.changes if each.stands}
        for name, change in persistent.items():
            what = f"{specimen} since {change.since}: {change.what}. See GET /specimens/{specimen}/trend"
            self._board.notice(f"trend:{specimen}:{name}", what)
        self._clear(specimen, but=persistent)

    def _clear(self, specimen: str, but: Container[str]) -> None:
        """Clear its alarms, by whole names: the name of another specimen may begin with this one."""
        for change in get_args(ChangeName.__value__):
            if change not in but:
                self._board.clear(f"trend:{specimen}:{change}")


def _files_in(folder: Path) -> frozenset[tuple[str, int]]:
    """Names and inodes of what is in a folder, but for the files of the index, which come and go with each query."""
    with os.scandir(folder) as entries:
        return frozenset((each.name, each.inode()) for each in entries if not each.name.startswith(INDEX))


class _Ended(Exception):
    """The process ends."""

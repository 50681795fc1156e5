"""The loop of a batch: files are cut into parts, sent to the workers, put together, and handed out as they finish."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from drivers.errors import InputError, PlatformError
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.features.fit.fit import FittedFrame
from platform_daemon.features.fit.fit_request import FitSettings

from .executors import WorkerPool
from .part import InputFile, count_frames, fit_part, fit_whole, put_together


@dataclass(frozen=True)
class Advanced:
    """So much of a file is fitted, 0 to 1."""

    path: Path
    share: float


@dataclass(frozen=True)
class Finished:
    """A file is fitted."""

    path: Path
    report: FitReport


@dataclass(frozen=True)
class Failed:
    """A file could not be fitted at all."""

    path: Path
    error: PlatformError


Event = Advanced | Finished | Failed


@dataclass
class _File:
    """A file under way: parts that wait (first, last frame), and the fitted frames by first frame of their part."""

    source: InputFile
    waiting: deque[tuple[int, int]]
    frames: int = 0
    parts: dict[int, list[FittedFrame]] = field(default_factory=dict)
    failed: bool = False

    @property
    def done(self) -> int:
        """Frames fitted."""
        return sum(map(len, self.parts.values()))


@dataclass(frozen=True)
class _Part:
    """Chosen frames number first .. last-1 of a file; last 0: the whole file. alone: nothing else runs at the time."""

    file: _File
    first: int
    last: int
    alone: bool = False


def fit_files(paths: Iterable[Path], settings: FitSettings, workers: WorkerPool) -> Iterator[Event]:
    """Fit files in the order given and hand each out as it finishes; one bad file does not stop the others.

    Files are opened, or read where the workers cannot, only shortly before their turn: there may be any number of them.
    """
    return _Batch(deque(paths), settings, workers).run()


class _Batch:
    def __init__(self, paths: deque[Path], settings: FitSettings, workers: WorkerPool) -> None:
        self._paths, self._settings, self._workers = paths, settings, workers
        self._current: _File | None = None
        self._running: dict[Future[Any], _Part] = {}
        self._suspects: deque[_Part] = deque()

    def run(self) -> Iterator[Event]:
        """Until every file is finished or failed."""
        try:
            while True:
                yield from self._fill()
                if not self._running:
                    return
                for future in wait(self._running, return_when=FIRST_COMPLETED).done:
                    yield from self._take(self._running.pop(future), future)
        finally:
            for future in self._running:
                future.cancel()

    def _fill(self) -> Iterator[Event]:
        """Keep twice as many parts in flight as workers; parts that may have killed one run alone."""
        while len(self._running) < 2 * self._workers.count:
            if self._suspects:
                if not self._running:
                    self._submit(replace(self._suspects.popleft(), alone=True))
                return
            if self._current is not None and self._current.waiting and not self._current.failed:
                self._submit(_Part(self._current, *self._current.waiting.popleft()))
            elif self._paths:
                path = self._paths.popleft()
                try:
                    self._current = self._begin(path)
                except (PlatformError, OSError) as error:
                    yield Failed(path, _ours(error, path))
            else:
                return

    def _begin(self, path: Path) -> _File:
        """A file with its parts.  Raises PlatformError, OSError."""
        size = self._workers.frames_per_part
        if size is None:
            return _File(InputFile(path, path.read_bytes() if self._workers.send_content else None), deque([(0, 0)]))
        frames = count_frames(InputFile(path), self._settings)
        return _File(InputFile(path), deque((k, min(k + size, frames)) for k in range(0, frames, size)), frames)

    def _submit(self, part: _Part) -> None:
        task = (fit_part, part.first, part.last) if part.last else (fit_whole,)
        future = self._workers.executor.submit(task[0], part.file.source, self._settings, *task[1:])
        self._running[future] = part

    def _take(self, part: _Part, future: Future[Any]) -> Iterator[Event]:
        """What a part that ended means for its file."""
        file, path = part.file, part.file.source.path
        if file.failed:
            return
        try:
            result = future.result()
            report = self._added(part, result) if part.last else result
        except BrokenProcessPool as error:
            if not part.alone:
                self._suspects.append(part)
                return
            file.failed = True
            yield Failed(path, _ours(error, path))
        except (Exception, CancelledError) as error:
            file.failed = True
            yield Failed(path, _ours(error, path))
        else:
            yield Advanced(path, file.done / file.frames) if report is None else Finished(path, report)

    def _added(self, part: _Part, frames: list[FittedFrame]) -> FitReport | None:
        """The file's report if these were its last frames.  Raises InputError."""
        file = part.file
        file.parts[part.first] = frames
        if file.done < file.frames:
            return None
        return put_together(file.source, self._settings, [f for k in sorted(file.parts) for f in file.parts[k]])


def _ours(error: BaseException, path: Path) -> PlatformError:
    """Any error of a file as one that a user can act on."""
    if isinstance(error, PlatformError):
        return error
    if isinstance(error, OSError):
        return InputError("cannot be read", where=str(path), why=error.strerror or str(error), remedy="check the file")
    if isinstance(error, BrokenProcessPool):
        remedy = "see the system's log: it may have run out of memory"
        return PlatformError("the process that fitted it died", where=str(path), remedy=remedy)
    if isinstance(error, CancelledError):
        return PlatformError("the worker that fitted it is gone", where=str(path), remedy="fit it again")
    why = f"{type(error).__name__}: {error}"
    return PlatformError("the fit failed unexpectedly", where=str(path), why=why, remedy="report it with the file")

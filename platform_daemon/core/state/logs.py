"""Log events of the daemon: on the terminal, and as lines of JSON in files that are rotated."""

from __future__ import annotations

import atexit
import io
import json
import logging
import os
import queue
import sys
import threading
from contextlib import suppress
from logging.handlers import QueueHandler, QueueListener, RotatingFileHandler
from pathlib import Path
from typing import TextIO, cast

import structlog
from structlog.typing import EventDict, WrappedLogger

LOGS = "logs"
"""Their folder in the data folder."""
_BYTES, _FILES, _WAITING = 10_000_000, 5, 10_000
_END_S = 1.0
_kept = logging.getLogger("platform_daemon.kept")
_kept.propagate = False


def log_from(level: int) -> None:
    """Write log events of at least this level to stderr, one per line; a stream that refuses a line only loses it."""
    _terminal.to = sys.stderr
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso"),
            structlog.processors.format_exc_info,
            _keep,
            structlog.processors.KeyValueRenderer(key_order=["timestamp", "level", "event"]),
        ],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        logger_factory=structlog.WriteLoggerFactory(cast(TextIO, _terminal)),
    )


def keep_log(folder: Path, name: str) -> None:
    """Write log events also to `folder`/`name`.jsonl, at most 60 MB; a disk that refuses a line only loses it.

    Logging never waits for a disk or a terminal, because threads write.  Each process needs a name of its own.
    """
    _terminal.write_in_thread()
    try:
        folder.mkdir(exist_ok=True)
        file = _File(
            folder / f"{name}.jsonl",
            maxBytes=_BYTES,
            backupCount=_FILES,
            encoding="utf-8",
            errors="backslashreplace",
            delay=True,
        )
    except OSError as error:
        structlog.get_logger().error("log_not_kept", folder=str(folder), error=str(error))
        return
    waiting: queue.Queue[logging.LogRecord] = queue.Queue(_WAITING)
    _kept.handlers[:] = [_Waiting(waiting)]
    _kept.setLevel(logging.DEBUG)
    listener = QueueListener(waiting, file)
    listener.start()
    atexit.register(listener.stop)


class _Terminal:
    """The stream of log events, with the interface that structlog expects.

    A terminal that is closed or halted (Ctrl-S), a pipe without a reader and a full disk would otherwise end or block
    the thread that logs, such as the one that moves a shot.
    """

    def __init__(self) -> None:
        self.to: TextIO | None = None
        self._waiting: queue.Queue[str | None] | None = None

    def write(self, line: str) -> None:
        """Write the line now, or queue it for the thread; a line that cannot be written is lost."""
        if self._waiting is None:
            self._write(line)
        else:
            with suppress(queue.Full):
                self._waiting.put_nowait(line)

    def flush(self) -> None:
        """Nothing is buffered."""

    def write_in_thread(self) -> None:
        """Let a thread write from now on.  Idempotent."""
        if self._waiting is None:
            self._waiting = queue.Queue(_WAITING)
            thread = threading.Thread(target=self._work, args=(self._waiting,), name="terminal", daemon=True)
            thread.start()
            atexit.register(self._end, self._waiting, thread)

    def _write(self, line: str) -> None:
        """Bypass the buffer of the stream, which Python would try to flush again at exit."""
        with suppress(OSError, ValueError, AttributeError):  # the last two: it is closed, there is none
            try:
                number = self.to.fileno()  # type: ignore[union-attr]
            except io.UnsupportedOperation:
                self.to.write(line)  # type: ignore[union-attr]
            else:
                os.write(number, line.encode(errors="backslashreplace"))

    def _work(self, waiting: queue.Queue[str | None]) -> None:
        while (line := waiting.get()) is not None:
            self._write(line)

    @staticmethod
    def _end(waiting: queue.Queue[str | None], thread: threading.Thread) -> None:
        with suppress(queue.Full):
            waiting.put_nowait(None)
        thread.join(_END_S)


_terminal = _Terminal()


class _File(RotatingFileHandler):
    def handleError(self, record: logging.LogRecord) -> None:
        """Ignore it: the event is on stderr, too."""


class _Waiting(QueueHandler):
    def handleError(self, record: logging.LogRecord) -> None:
        """Ignore it: the queue is full, as the disk is too slow."""


def _keep(logger: WrappedLogger, name: str, event: EventDict) -> EventDict:
    if _kept.handlers:
        first = {key: event[key] for key in ("timestamp", "level", "event") if key in event}
        _kept.info("%s", json.dumps({**first, **event}, default=str, ensure_ascii=False))
    return event

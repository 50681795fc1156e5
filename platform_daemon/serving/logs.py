"""Log events of the daemon: on the terminal, and as lines of JSON in files that are changed when they are full."""

from __future__ import annotations

import atexit
import json
import logging
import queue
import sys
from logging.handlers import QueueHandler, QueueListener, RotatingFileHandler
from pathlib import Path

import structlog
from structlog.typing import EventDict, WrappedLogger

LOGS = "logs"
"""Their folder in the data folder."""
_BYTES, _FILES, _WAITING = 10_000_000, 5, 10_000
_kept = logging.getLogger("platform_daemon.kept")
_kept.propagate = False


def log_from(level: int) -> None:
    """Log events of at least this level, one per line, on stderr."""
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso"),
            structlog.processors.format_exc_info,
            _keep,
            structlog.processors.KeyValueRenderer(key_order=["timestamp", "level", "event"]),
        ],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        logger_factory=structlog.PrintLoggerFactory(sys.stderr),
    )


def keep_log(folder: Path, name: str) -> None:
    """From now on they are also in `folder`/`name`.jsonl, at most 60 MB of them; a disk that refuses loses them only.

    Who logs waits for no disk: a thread writes.  For one process; another one writes another name.
    """
    try:
        folder.mkdir(exist_ok=True)
        file = _File(folder / f"{name}.jsonl", maxBytes=_BYTES, backupCount=_FILES, encoding="utf-8", delay=True)
    except OSError as error:
        structlog.get_logger().error("log_not_kept", folder=str(folder), error=str(error))
        return
    waiting: queue.Queue[logging.LogRecord] = queue.Queue(_WAITING)
    _kept.handlers[:] = [_Waiting(waiting)]
    _kept.setLevel(logging.DEBUG)
    listener = QueueListener(waiting, file)
    listener.start()
    atexit.register(listener.stop)


class _File(RotatingFileHandler):
    def handleError(self, record: logging.LogRecord) -> None:
        """It is on stderr all the same."""


class _Waiting(QueueHandler):
    def handleError(self, record: logging.LogRecord) -> None:
        """More wait than the disk takes."""


def _keep(logger: WrappedLogger, name: str, event: EventDict) -> EventDict:
    if _kept.handlers:
        first = {key: event[key] for key in ("timestamp", "level", "event") if key in event}
        _kept.info("%s", json.dumps({**first, **event}, default=str, ensure_ascii=False))
    return event

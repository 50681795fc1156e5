"""What the processes of the daemon share: log, exit codes, signals, priority."""

from __future__ import annotations

import logging
import os
import signal
import time
from types import FrameType
from typing import NoReturn

from drivers.errors import PlatformError
from platform_daemon.core.state.logs import log_from

from .child import ParentLink
from .options import ServeOptions

_POLL_S = 0.2
_ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)


def main(name: str, options: str, sockets: tuple[int, ...]) -> int:
    """Run the process of that name; its exit code, 2 for bad input."""
    end_on_signals()
    parent = ParentLink()
    log_from(logging.INFO)
    try:
        parsed = ServeOptions.model_validate_json(options)
        if name == "hardware":
            from .hardware_process import run_hardware

            run_hardware(parsed, parent)
        elif name == "stop":
            from .stop_process import run_stop

            run_stop(parsed, parent, sockets)
        else:
            from .web_process import run_web

            run_web(parsed, parent, sockets)
    except KeyboardInterrupt:
        return 0
    except PlatformError as error:
        parent.report_failure(str(error), nothing_moved=error.nothing_moved)
        return 2 if error.nothing_moved else 1
    except OSError as error:
        parent.report_failure(f"{error.filename or ''}: {error.strerror or error}", nothing_moved=False)
        return 1
    return 0


def end_on_signals() -> None:
    """Let the first ending signal raise KeyboardInterrupt in the main thread, and ignore further ones."""
    for number in _ENDING:
        signal.signal(number, _on_first)


def _on_first(number: int, frame: FrameType | None) -> None:
    for each in _ENDING:
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt


def wait_for_signals() -> NoReturn:
    """Sleep until a signal raises KeyboardInterrupt; one that reaches another thread does not wake this one."""
    while True:
        time.sleep(_POLL_S)


def lower_priority(nice: int) -> None:
    """Add to the niceness of this process: more important processes get the processor first."""
    os.nice(nice)

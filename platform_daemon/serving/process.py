"""What the processes of the daemon share: their log, how they fail, and by what they end."""

from __future__ import annotations

import logging
import os
import signal
import time
from types import FrameType
from typing import NoReturn

from drivers.errors import PlatformError

from .child import Life
from .logs import log_from
from .options import ServeOptions

_LOOK_S = 0.2
_ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)


def main(name: str, options: str, sockets: tuple[int, ...]) -> int:
    """The process of that name; its exit code, 2 for bad input."""
    end_on_signals()
    life = Life()
    log_from(logging.INFO)
    try:
        asked = ServeOptions.model_validate_json(options)
        if name == "hardware":
            from .hardware_process import run_hardware

            run_hardware(asked, life)
        elif name == "stop":
            from .stop_process import run_stop

            run_stop(asked, life, sockets)
        else:
            from .web_process import run_web

            run_web(asked, life, sockets)
    except KeyboardInterrupt:
        return 0
    except PlatformError as error:
        life.fails(str(error), nothing_moved=error.nothing_moved)
        return 2 if error.nothing_moved else 1
    except OSError as error:
        life.fails(f"{error.filename or ''}: {error.strerror or error}", nothing_moved=False)
        return 1
    return 0


def end_on_signals() -> None:
    """The first signal that ends raises KeyboardInterrupt in the main thread; those after it are ignored."""
    for number in _ENDING:
        signal.signal(number, _first)


def _first(number: int, frame: FrameType | None) -> None:
    for each in _ENDING:
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt


def wait_for_signals() -> NoReturn:
    """Until a signal ends the process: one that reaches another thread does not wake this one."""
    while True:
        time.sleep(_LOOK_S)


def step_back(nice: int) -> None:
    """What matters more than this process gets the processor first."""
    os.nice(nice)

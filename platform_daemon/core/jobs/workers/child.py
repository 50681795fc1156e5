"""The main loop of a worker process: a task, its result, the next task; it ends with the process that started it."""

from __future__ import annotations

import os
import pickle
import resource
import signal
import threading
from dataclasses import dataclass
from multiprocessing import connection as connections
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from typing import Any

from drivers.errors import PlatformError
from drivers.realtime import set_ordinary_priority

MB = 1_000_000


@dataclass(frozen=True)
class ProgressMessage:
    """How much of the task is done, and what it does now."""

    done: float
    what: str


@dataclass(frozen=True)
class ResultMessage:
    """The result; resident_bytes: memory that the process holds now."""

    value: Any
    resident_bytes: int


@dataclass(frozen=True, kw_only=True)
class ErrorMessage:
    """The task has failed.

    Attributes:
        error: one of the project's errors, None: another one.
        resident_bytes: memory that the process holds now.
        out_of_memory: the task needed more than it may have.
        unexpected: the text of an error that is none of the project's.
    """

    error: PlatformError | None = None
    resident_bytes: int = 0
    out_of_memory: bool = False
    unexpected: str = ""


def run_worker(pipe: Connection, nice: int) -> None:
    """Receive (memory_mb, task) and answer with ProgressMessage, then ResultMessage or ErrorMessage, until the other
    end of the pipe is closed."""
    # Signals of a terminal are for the parent to handle; it kills this process when it needs it no more.
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    set_ordinary_priority()  # the thread that moves the shot may have started it, whose priority it would inherit
    os.nice(nice)
    threading.Thread(target=_exit_with_parent, name="parent", daemon=True).start()
    while True:
        try:
            memory_mb, task = pickle.loads(pipe.recv_bytes())
        except EOFError:
            return
        answer = _run(task, memory_mb, pipe)
        _send(pipe, answer)
        del task, answer


def resident_bytes(pid: int | str = "self") -> int:
    """Memory that a process holds."""
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def _run(task: Any, memory_mb: int, pipe: Connection) -> ResultMessage | ErrorMessage:
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (memory_mb * MB, hard))
        return ResultMessage(task(lambda done, what: _send(pipe, ProgressMessage(done, what))), resident_bytes())
    except MemoryError:
        return ErrorMessage(out_of_memory=True)
    except PlatformError as error:
        return ErrorMessage(error=error, resident_bytes=resident_bytes())
    except Exception as error:  # whatever it is, the caller must receive it
        return _unexpected(error)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


def _send(pipe: Connection, message: ProgressMessage | ResultMessage | ErrorMessage) -> None:
    try:
        data = pickle.dumps(message)
    except Exception as error:  # an error or a result that cannot be pickled
        data = pickle.dumps(_unexpected(error))
    pipe.send_bytes(data)


def _unexpected(error: Exception) -> ErrorMessage:
    return ErrorMessage(unexpected=f"{type(error).__name__}: {error}")


def _exit_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    connections.wait([parent.sentinel])
    os._exit(1)

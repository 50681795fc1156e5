"""What a worker does: a task, its result, the next task; it ends when whoever started it does."""

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
from drivers.urgency import stand_in_line

MB = 1_000_000


@dataclass(frozen=True)
class Told:
    """How far it is."""

    done: float
    what: str


@dataclass(frozen=True)
class Brought:
    """What came out; resident: bytes that the process holds now."""

    value: Any
    resident: int


@dataclass(frozen=True)
class Failed:
    """An error; resident: bytes that the process holds now; memory: it wanted more than there is; unforeseen: its
    words, where it is none of the project's."""

    error: PlatformError | None
    resident: int = 0
    memory: bool = False
    unforeseen: str = ""


def serve(pipe: Connection, nice: int) -> None:
    """Tasks as (memory_mb, task), answered by Told and then Brought or Failed; until the other end goes."""
    # What ends a daemon from a terminal is its parent's to hear; this one is killed when it is not needed any more.
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    stand_in_line()  # it may come from the thread that moves the shot
    os.nice(nice)
    threading.Thread(target=_end_with_parent, name="parent", daemon=True).start()
    while True:
        try:
            memory_mb, task = pickle.loads(pipe.recv_bytes())
        except EOFError:
            return
        answer = _computed(task, memory_mb, pipe)
        _send(pipe, answer)
        del task, answer


def _computed(task: Any, memory_mb: int, pipe: Connection) -> Brought | Failed:
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (memory_mb * MB, hard))
        return Brought(task(lambda done, what: _send(pipe, Told(done, what))), resident())
    except MemoryError:
        return Failed(None, memory=True)
    except PlatformError as error:
        return Failed(error, resident())
    except Exception as error:  # whatever it is, the one who asked hears of it
        return Failed(None, unforeseen=f"{type(error).__name__}: {error}")
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


def _send(pipe: Connection, message: Any) -> None:
    try:
        data = pickle.dumps(message)
    except Exception as error:  # an error or a result that cannot be pickled
        data = pickle.dumps(Failed(None, unforeseen=f"{type(error).__name__}: {error}"))
    pipe.send_bytes(data)


def resident(pid: int | str = "self") -> int:
    """Bytes of memory that a process holds."""
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    connections.wait([parent.sentinel])
    os._exit(1)

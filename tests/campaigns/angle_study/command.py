"""`platform-daemon` as a user calls it, in a process of its own that is kept, with a limit of time and of memory."""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import os
import resource
import sys
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

TOO_LONG = -2
TRACEBACK = -1
_MOST_BYTES = 10 * 2**30  # of addresses


@dataclass(frozen=True)
class Answer:
    """How a call ended.  code: its exit code, TRACEBACK or TOO_LONG; memory_mb: the most it held."""

    code: int
    out: str
    errors: str
    seconds: float
    memory_mb: float


class Command:
    """Calls one after the other; a process that takes too long is ended and replaced."""

    def __init__(self, most_s: float = 300.0) -> None:
        self._most_s = most_s
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    def __call__(self, *arguments: object) -> Answer:
        """One call."""
        pipe, began = self._started(), time.monotonic()
        pipe.send([str(a) for a in arguments])
        try:
            if pipe.poll(self._most_s):
                return Answer(*pipe.recv())
            why = f"not done after {self._most_s:.0f} s"
        except EOFError:
            why = "the process died"
        memory = _most_mb(self._process.pid) if self._process is not None else 0.0
        self.close()
        return Answer(TOO_LONG, "", why, time.monotonic() - began, memory)

    def _started(self) -> Connection:
        if self._pipe is None:
            context = multiprocessing.get_context("spawn")
            self._pipe, there = context.Pipe()
            self._process = context.Process(target=_serve, args=(there,), daemon=True)
            self._process.start()
            there.close()
        return self._pipe

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
        self._process = self._pipe = None


def _most_mb(pid: int | None) -> float:
    try:
        lines = Path(f"/proc/{pid or os.getpid()}/status").read_text(encoding="ascii").splitlines()
    except OSError:
        return 0.0
    return next((float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmHWM")), 0.0)


def _serve(pipe: Connection) -> None:
    from platform_daemon.cli.main import main

    resource.setrlimit(resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES))
    while True:
        try:
            arguments = pipe.recv()
        except EOFError:
            return
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # the most memory is counted anew
        out, errors, began, code = io.StringIO(), io.StringIO(), time.monotonic(), 0
        sys.argv = ["platform-daemon", *arguments]
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            try:
                main()
            except SystemExit as end:
                code = end.code if isinstance(end.code, int) else 0
            except BaseException:
                code = TRACEBACK
                errors.write(traceback.format_exc())
        pipe.send((code, out.getvalue(), errors.getvalue(), time.monotonic() - began, _most_mb(None)))

"""A process of the daemon: the parent's end of it, and its own end.

Two pipes join them.  Over standard input the parent says `go`; the end of that pipe says that the parent has ended, and
the process ends in order.  Over standard output the process reports the steps of its start, and then sends heartbeats.
"""

from __future__ import annotations

import contextlib
import gc
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from datetime import UTC, datetime

from drivers.errors import PlatformError

from .heartbeat import HeartbeatMonitor, start_heartbeat
from .options import ServeOptions

CHECKED, READY, GO = b"checked\n", b"ready\n", b"go\n"
_BAD_INPUT, _FAILED = b"refuses\n", b"failed\n"
_START_S = 120.0  # on a busy computer


class StartFailed(PlatformError):
    """A process of the daemon could not start; the reason that it gave is the text of this error."""

    title = "Start failed"

    def __init__(self, name: str, received: bytes) -> None:
        reason = _reason(received)
        super().__init__(reason or f"the {name} process could not start", remedy="" if reason else "its log says why")
        self.nothing_moved = _BAD_INPUT in received
        self._reason = reason

    def __str__(self) -> str:
        return self._reason or super().__str__()


class Child:
    """The parent's end of a process, which is started at once.

    The process has a session of its own: signals of a terminal reach the parent only.

    sockets: descriptors of what it listens on; files: of what its options name.
    """

    def __init__(
        self, name: str, options: ServeOptions, *, sockets: Sequence[int] = (), files: Sequence[int] = ()
    ) -> None:
        self.name = name
        # -P: the same installation as this process, whatever other checkout is the working directory
        command = [sys.executable, "-P", "-m", "platform_daemon.processes", name, options.model_dump_json()]
        self.process = subprocess.Popen(
            [*command, *map(str, sockets)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            pass_fds=(*sockets, *files),
        )
        self.started_s = time.monotonic()
        try:
            self._pidfd = os.pidfd_open(self.process.pid)
        except OSError:
            with self.process:  # without a pidfd its end would not be seen
                self.process.kill()
            raise
        assert self.process.stdout is not None
        self._heartbeats = HeartbeatMonitor(self.process.stdout.fileno(), _START_S)

    def wait_for(self, step: bytes) -> None:
        """Wait until it has reported a step of its start: CHECKED or READY.

        Raises StartFailed if it has ended, or reports nothing for two minutes.
        """
        assert self.process.stdout is not None
        pipe = self.process.stdout.fileno()
        received = b""
        until_s = time.monotonic() + _START_S
        while step not in received:
            if not select.select([pipe], [], [], max(0.0, until_s - time.monotonic()))[0]:
                why = f"the {self.name} process has reported nothing for {_START_S:g} s; is this computer overloaded?"
                raise StartFailed(self.name, _FAILED + why.encode())
            part = os.read(pipe, 4096)
            if not part:
                raise StartFailed(self.name, received)
            received += part
        if step == READY:
            self._heartbeats.started()

    def go(self) -> None:
        """Let it continue its start."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):  # it has ended, which its pidfd shows
            os.write(self.process.stdin.fileno(), GO)

    def hangs(self) -> bool:
        """It exists and sends no heartbeats.  To be called about every second, after `wait_for`."""
        return self._heartbeats.timed_out()

    def exit_reason(self) -> str:
        """The reason that a process gave before it ended; empty: none."""
        return _reason(self._heartbeats.last_output())

    def kill(self) -> None:
        """Kill it; `fileno` shows when it has ended."""
        self.process.kill()

    def fileno(self) -> int:
        """A descriptor that can be read once it has ended."""
        return self._pidfd

    def end(self, patience_s: float) -> int:
        """Ask it to end in order, and kill it if it does not; its exit code.  Idempotent."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            self.process.send_signal(signal.SIGCONT)
        try:
            code = self.process.wait(patience_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()
        if self._pidfd >= 0:
            os.close(self._pidfd)
            self._pidfd = -1
        return code


def _reason(received: bytes) -> str:
    return (received.partition(_BAD_INPUT)[2] or received.partition(_FAILED)[2]).decode(errors="replace")


class ParentLink:
    """The process's own end.  Standard output is reserved for what is reported here; prints go to the log.

    how_killed: in words, when the parent has ended without telling this process to end; None: it has not.
    """

    def __init__(self) -> None:
        self.how_killed: str | None = None
        self._pipe = os.dup(sys.stdout.fileno())
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())

    def report(self, step: bytes) -> None:
        """Report a step of the start.  After READY the process also sends heartbeats, and searches for garbage."""
        with contextlib.suppress(OSError):  # the parent has ended, which `end_with_parent` sees
            os.write(self._pipe, step)
        if step == READY:
            start_heartbeat(self._pipe)
            gc.freeze()  # what has been loaded stays
            gc.enable()

    def report_failure(self, error: str, *, nothing_moved: bool) -> None:
        """Report why the process ends.  error: one line; nothing_moved: its options are wrong."""
        self.report((_BAD_INPUT if nothing_moved else _FAILED) + error.encode(errors="replace"))

    def wait_to_go(self) -> bool:
        """Wait until the parent says `go`.  False: it has ended, or ends this process."""
        return os.read(sys.stdin.fileno(), len(GO)) == GO

    def end_with_parent(self) -> None:
        """From now on this process ends as by SIGTERM when its parent does."""
        threading.Thread(target=self._watch_parent, name="parent", daemon=True).start()

    def _watch_parent(self) -> None:
        while os.read(sys.stdin.fileno(), 100):
            pass
        now = datetime.now(UTC).isoformat(timespec="seconds")
        self.how_killed = f"its main process was killed or crashed at {now}"
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)

"""A process of the daemon: the parent's end of it, and its own end.

Two pipes join them.  Over standard input the parent says `go`; its end says that the parent is gone, and the process
ends in order.  Over standard output the process says how far its start is, and from then on that it lives.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from drivers.errors import PlatformError

from .options import ServeOptions
from .pulse import Pulse, beat

CHECKED, READY, GO = b"checked\n", b"ready\n", b"go\n"
_REFUSES, _FAILED = b"refuses\n", b"failed\n"
_START_S = 120.0  # on a busy computer


class StartFailed(PlatformError):
    """A process of the daemon could not start; what it said is the text of this error."""

    title = "Start failed"

    def __init__(self, name: str, heard: bytes) -> None:
        said = _reason(heard)
        super().__init__(said or f"the {name} process could not start", remedy="" if said else "its log says why")
        self.nothing_moved = _REFUSES in heard
        self._said = said

    def __str__(self) -> str:
        return self._said or super().__str__()


class Child:
    """One process, started at once.  It has a session of its own: what a terminal sends reaches the parent only.

    sockets: descriptors of what it listens on; files: of what its options name.
    """

    def __init__(
        self, name: str, options: ServeOptions, sockets: Sequence[int] = (), files: Sequence[int] = ()
    ) -> None:
        self.name = name
        command = [sys.executable, "-m", "platform_daemon.serving", name, options.model_dump_json()]
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
            with self.process:  # nobody would wait for its end
                self.process.kill()
            raise
        assert self.process.stdout is not None
        self._pulse = Pulse(self.process.stdout.fileno(), _START_S)

    def wait_for(self, word: bytes) -> None:
        """Until it has said so.  Raises StartFailed if it has ended, or says nothing for two minutes."""
        assert self.process.stdout is not None
        pipe, heard, until_s = self.process.stdout.fileno(), b"", time.monotonic() + _START_S
        while word not in heard:
            if not select.select([pipe], [], [], max(0.0, until_s - time.monotonic()))[0]:
                raise StartFailed(self.name, b"it says nothing")
            said = os.read(pipe, 4096)
            if not said:
                raise StartFailed(self.name, heard)
            heard += said
        if word == READY:
            self._pulse.begin()

    def go(self) -> None:
        """Tell it to go on."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):  # it has ended: whoever waits for it will see
            os.write(self.process.stdin.fileno(), GO)

    def hangs(self) -> bool:
        """It is there and gives no sign of life.  To be asked about every second once it was waited for."""
        return self._pulse.stopped()

    def why(self) -> str:
        """Of one that has ended: what it gave as the reason; empty: nothing."""
        return _reason(self._pulse.last_words())

    def kill(self) -> None:
        """Whatever it is at; `fileno` tells when it has ended."""
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


def _reason(heard: bytes) -> str:
    return (heard.partition(_REFUSES)[2] or heard.partition(_FAILED)[2]).decode(errors="replace")


class Life:
    """The process's own end.  Standard output is given up to what is said here; prints go to the log."""

    def __init__(self) -> None:
        self._says = os.dup(sys.stdout.fileno())
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())

    def say(self, word: bytes) -> None:
        """Tell the parent.  Once it is ready a process says also that it lives, again and again."""
        with contextlib.suppress(OSError):  # it is gone, which `follow` sees
            os.write(self._says, word)
        if word == READY:
            beat(self._says)

    def fails(self, error: str, *, nothing_moved: bool) -> None:
        """Tell the parent why the process ends; error: one line; nothing_moved: by what it was asked for."""
        self.say((_REFUSES if nothing_moved else _FAILED) + error.encode(errors="replace"))

    def wait_to_go(self) -> bool:
        """False: the parent is gone, or does not want us."""
        return os.read(sys.stdin.fileno(), len(GO)) == GO

    def follow(self) -> None:
        """From now on this process ends as by SIGTERM when its parent does."""
        threading.Thread(target=self._follow, name="life", daemon=True).start()

    def _follow(self) -> None:
        while os.read(sys.stdin.fileno(), 100):
            pass
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)

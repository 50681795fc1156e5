"""The owner's end of a guard: starting it, signs of life, and what happens if the guard itself is gone."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import sys
import threading

from drivers.errors import InterlockError
from drivers.power_guard import NoGuard, PowerGuard
from drivers.registry import PlatformSection

from .watch import ALIVE, ENDED, MAY_COME, OFF, READY, SWITCHING_OFF

_START_S = 20.0
_END_S = 2.0
_IN_PROCESS = {"simulated"}  # devices that die with it


def guard_for(section: PlatformSection) -> PowerGuard:
    """A guard in a process of its own, or none where no device outlives this one."""
    outputs = {section.io_card.backend, section.power_amplifier.backend, section.tx_rx_switch.backend}
    return GuardProcess(section) if outputs - _IN_PROCESS else NoGuard()


class GuardProcess:
    """See PowerGuard.  Started at once, waited for before the first power, started anew if it has died."""

    def __init__(self, section: PlatformSection) -> None:
        self._tables = section.model_dump_json().encode() + b"\n"
        self._lock = threading.Lock()
        self._power = self._closed = False
        self._process = self._started()

    @property
    def pid(self) -> int:
        """Of the process that watches now."""
        return self._process.pid

    def power_may_come(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._process.poll() is not None:
                self._let_go(self._process)
                self._process = self._started()
            self._power = self._is_ready() and self._said(MAY_COME)
            if not self._power:
                raise InterlockError(
                    "nobody would switch the amplifier off if this process died",
                    why=f"the guard process {self.pid} does not answer",
                    remedy="start the daemon anew; if that does not help, look into its log for the guard's error",
                )

    def alive(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power and not self._said(ALIVE):
                raise InterlockError(
                    "the guard process has died in a shot", why=f"it was process {self.pid}", remedy="repeat the shot"
                )

    def switching_off(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power:
                self._said(SWITCHING_OFF)

    def power_is_off(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power:
                self._said(OFF)
                self._power = False

    def close(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            self._said(ENDED)
            self._let_go(self._process)

    def _started(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "platform_daemon.supervisor", str(os.getpid())]
        process = subprocess.Popen(  # a session of its own: what a terminal sends does not reach it
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )
        assert process.stdin is not None
        with contextlib.suppress(OSError):  # it is asked whether it lives before any power
            os.write(process.stdin.fileno(), self._tables)
        self._ready = False
        return process

    @staticmethod
    def _let_go(process: subprocess.Popen[bytes]) -> None:
        """Its pipes are closed and its end is waited for, but not for ever."""
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_END_S)

    def _is_ready(self) -> bool:
        assert self._process.stdout is not None
        if not self._ready and select.select([self._process.stdout], [], [], _START_S)[0]:
            self._ready = os.read(self._process.stdout.fileno(), len(READY)) == READY
        return self._ready

    def _said(self, word: bytes) -> bool:
        """False: nobody listens."""
        assert self._process.stdin is not None
        try:
            os.write(self._process.stdin.fileno(), word)
        except (OSError, ValueError):
            return False
        return True

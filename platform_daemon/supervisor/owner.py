"""The owner's end of a guard: starting it, signs of life, and what happens if the guard itself is gone."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import sys
import threading
from pathlib import Path

from drivers.errors import InterlockError
from drivers.power_guard import NoGuard, PowerGuard
from drivers.registry import PlatformSection

from .lock_file import clear, refuse
from .ownership import take
from .places import place_of
from .watch import ALIVE, ENDED, HEARD, MAY_COME, OFF, READY, SWITCHING_OFF

_START_S = 20.0
_END_S = 2.0
_HEARD_S = 2.0  # for one byte; a busy computer was never seen to take 0.3 s
_IN_PROCESS = {"simulated"}  # devices that die with it


def guard_for(section: PlatformSection, max_lease_s: float | None = None, data: Path | None = None) -> PowerGuard:
    """A guard in a process of its own, or none where no device outlives this one.

    To be made before the devices are opened: this process owns them from here on, until the guard is closed.
    max_lease_s: longest lease that the site allows, s; data: data folder of the owner.  Raises ConfigError,
    DeviceDenied if another process owns them.
    """
    return GuardProcess(section, max_lease_s, data) if needs_guard(section) else NoGuard()


def needs_guard(section: PlatformSection) -> bool:
    """Some output outlives the process that owns it."""
    outputs = {section.io_card.backend, section.power_amplifier.backend, section.tx_rx_switch.backend}
    return bool(outputs - _IN_PROCESS)


class GuardProcess:
    """See PowerGuard.  Waited for before the first power, started anew if it has died."""

    def __init__(self, section: PlatformSection, max_lease_s: float | None = None, data: Path | None = None) -> None:
        self._tables = section.model_dump_json().encode() + b"\n"
        self._lease_s, self._max_lease_s = section.guard.lease_s, max_lease_s
        self._lock = threading.Lock()
        self._power = self._closed = self._ready = False
        self._process: subprocess.Popen[bytes] | None = None
        self._place = place_of(section)
        self._ownership = take(self._place, section.name, data)

    @property
    def pid(self) -> int:
        """Of the process that watches now."""
        return self._watching().pid

    def watch(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if not self._closed:
                self._watching()

    def unfit(self) -> InterlockError | None:
        """See PowerGuard."""
        most_s = self._max_lease_s
        if most_s is not None and self._lease_s > most_s:
            error = InterlockError(
                f"the lease of the guard is {self._lease_s:g} s",
                where="guard.lease_s",
                why=f"limits.max_lease_s is {most_s:g} s",
                remedy="shorten the lease, or have the limit changed by whoever is responsible for the platform",
            )
            error.nothing_moved = True
            return error
        return None

    def refusal(self) -> InterlockError | None:
        """See PowerGuard."""
        unfit = self.unfit()
        if unfit is not None:
            return unfit
        try:
            refuse(self._place)
        except InterlockError as error:
            return error
        return None

    def reset(self, by: str, reason: str) -> str | None:
        """See PowerGuard."""
        fault = clear(self._place, by, reason)
        return None if fault is None else str(fault)

    def power_may_come(self) -> None:
        """See PowerGuard."""
        with self._lock:
            refusal = self.refusal()
            if refusal is not None:
                raise refusal
            process = self._watching()
            self._ownership.power(may_be_on=True)
            self._power = process.poll() is None and self._hears()
            if not self._power:  # dead, or halted
                process.kill()
                self._let_go(process)
                process = self._process = self._started()
                self._power = self._hears()
            if not self._power:
                raise InterlockError(
                    "nobody would switch the amplifier off if this process died",
                    why=f"the guard process {process.pid} does not answer",
                    remedy="start the daemon anew; if that does not help, look into its log for the guard's error",
                )

    def alive(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power and not self._said(ALIVE):
                raise InterlockError(
                    "the guard process has died in a shot",
                    why=f"it was process {self._watching().pid}",
                    remedy="repeat the shot",
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
            if not self._closed:
                self._ownership.power(may_be_on=False)

    def close(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            if self._process is not None:
                self._said(ENDED)
                self._let_go(self._process)
            self._ownership.release()

    def _watching(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            self._process = self._started()
        return self._process

    def _started(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "platform_daemon.supervisor", str(os.getpid())]
        process = subprocess.Popen(  # a session of its own: what a terminal sends does not reach it
            [*command, str(self._place), str(self._ownership.fd)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            pass_fds=self._ownership.held,
        )
        assert process.stdin is not None
        with contextlib.suppress(OSError):  # it is asked whether it lives before any power
            os.write(process.stdin.fileno(), self._tables)
        self._ready = False
        return process

    @staticmethod
    def _let_go(process: subprocess.Popen[bytes]) -> None:
        """Its pipes are closed and its end is waited for, but not for ever: a halted one would own the devices."""
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _is_ready(self) -> bool:
        pipe = self._watching().stdout
        assert pipe is not None
        if not self._ready and select.select([pipe], [], [], _START_S)[0]:
            self._ready = os.read(pipe.fileno(), len(READY)) == READY
        return self._ready

    def _hears(self) -> bool:
        """It is told that power may come, and has answered."""
        if not (self._is_ready() and self._said(MAY_COME)):
            return False
        pipe = self._watching().stdout
        assert pipe is not None
        return bool(select.select([pipe], [], [], _HEARD_S)[0]) and os.read(pipe.fileno(), 1) == HEARD

    def _said(self, word: bytes) -> bool:
        """False: nobody listens."""
        pipe = self._watching().stdin
        assert pipe is not None
        try:
            os.write(pipe.fileno(), word)
        except (OSError, ValueError):
            return False
        return True

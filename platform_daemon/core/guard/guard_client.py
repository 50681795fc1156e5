"""The owner's end of a guard: starting it, heartbeats, and what happens if the guard itself dies."""

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
from drivers.registry import PlatformSection, outputs_outlive_process

from .fault_latch import check_no_fault, clear_fault
from .ownership import take_ownership
from .state_dir import state_dir_of
from .watch import ALIVE, ENDED, HEARD, MAY_COME, OFF, READY, SWITCHING_OFF

_START_TIMEOUT_S = 20.0
_END_TIMEOUT_S = 2.0
_ANSWER_TIMEOUT_S = 2.0  # for one byte; on a busy computer it never took 0.3 s


def guard_for(section: PlatformSection, max_lease_s: float | None = None, data: Path | None = None) -> PowerGuard:
    """A guard in a process of its own, or none where no device outlives this process.

    Call it before the devices are opened: this process owns them from then on, until the guard is closed.
    max_lease_s: longest lease that the site allows, s; data: data folder of the owner.  Raises ConfigError,
    DeviceDenied if another process owns them.
    """
    return GuardClient(section, max_lease_s, data) if outputs_outlive_process(section) else NoGuard()


class GuardClient:
    """A PowerGuard in another process, which must have started before the first power; one that died is replaced."""

    def __init__(self, section: PlatformSection, max_lease_s: float | None = None, data: Path | None = None) -> None:
        self._tables = section.model_dump_json().encode() + b"\n"
        self._lease_s = section.guard.lease_s
        self._max_lease_s = max_lease_s
        self._lock = threading.Lock()
        self._power = False
        self._closed = False
        self._ready = False
        self._process: subprocess.Popen[bytes] | None = None
        self._state_dir = state_dir_of(section)
        self._ownership = take_ownership(self._state_dir, section.name, data)

    @property
    def pid(self) -> int:
        """Process id of the guard."""
        return self._guard().pid

    def watch(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if not self._closed:
                self._guard()

    def unfit(self) -> InterlockError | None:
        """See PowerGuard."""
        most_s = self._max_lease_s
        if most_s is not None and self._lease_s > most_s:
            error = InterlockError(
                f"the lease of the guard is {self._lease_s:g} s",
                where="guard.lease_s",
                why=f"limits.max_lease_s is {most_s:g} s",
                remedy="shorten the lease, or have the limit changed by the person responsible for the platform",
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
            check_no_fault(self._state_dir)
        except InterlockError as error:
            return error
        return None

    def reset(self, by: str, reason: str) -> str | None:
        """See PowerGuard."""
        fault = clear_fault(self._state_dir, by, reason)
        return None if fault is None else str(fault)

    def power_may_come(self) -> None:
        """See PowerGuard."""
        with self._lock:
            refusal = self.refusal()
            if refusal is not None:
                raise refusal
            process = self._guard()
            self._ownership.power(may_be_on=True)
            self._power = process.poll() is None and self._acknowledges()
            if not self._power:  # dead, or halted
                process.kill()
                self._end(process)
                process = self._start()
                self._process = process
                self._power = self._acknowledges()
            if not self._power:
                raise InterlockError(
                    "no process would switch the amplifier off if this one died",
                    why=f"the guard process {process.pid} does not answer",
                    remedy="restart the daemon; if that does not help, look into its log for the guard's error",
                )

    def alive(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power and not self._send(ALIVE):
                raise InterlockError(
                    "the guard process has died in a shot",
                    why=f"it was process {self._guard().pid}",
                    remedy="repeat the shot",
                )

    def switching_off(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power:
                self._send(SWITCHING_OFF)

    def power_is_off(self) -> None:
        """See PowerGuard."""
        with self._lock:
            if self._power:
                self._send(OFF)
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
                self._send(ENDED)
                self._end(self._process)
            self._ownership.release()

    def _guard(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            self._process = self._start()
        return self._process

    def _start(self) -> subprocess.Popen[bytes]:
        # -P: the same installation as this process, whatever other checkout is the working directory
        command = [sys.executable, "-P", "-m", "platform_daemon.core.guard", str(os.getpid())]
        process = subprocess.Popen(  # a session of its own: signals of a terminal do not reach it
            [*command, str(self._state_dir), str(self._ownership.fd)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            pass_fds=self._ownership.held,
        )
        assert process.stdin is not None
        with contextlib.suppress(OSError):  # whether it lives is asked before any power
            os.write(process.stdin.fileno(), self._tables)
        self._ready = False
        return process

    @staticmethod
    def _end(process: subprocess.Popen[bytes]) -> None:
        """Close its pipes and wait for its end; kill it after a time-out, as a halted guard would own the devices."""
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()
        try:
            process.wait(_END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _is_ready(self) -> bool:
        pipe = self._guard().stdout
        assert pipe is not None
        if not self._ready and select.select([pipe], [], [], _START_TIMEOUT_S)[0]:
            self._ready = os.read(pipe.fileno(), len(READY)) == READY
        return self._ready

    def _acknowledges(self) -> bool:
        """Announce to the guard that power may come.  True: it has acknowledged in time."""
        if not (self._is_ready() and self._send(MAY_COME)):
            return False
        pipe = self._guard().stdout
        assert pipe is not None
        return bool(select.select([pipe], [], [], _ANSWER_TIMEOUT_S)[0]) and os.read(pipe.fileno(), 1) == HEARD

    def _send(self, message: bytes) -> bool:
        """Send a message.  False: the guard has ended."""
        pipe = self._guard().stdin
        assert pipe is not None
        try:
            os.write(pipe.fileno(), message)
        except (OSError, ValueError):
            return False
        return True

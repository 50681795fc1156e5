"""Switching everything off over the local socket, and what is done if no process answers there."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import time
import weakref
from pathlib import Path

import structlog

from drivers.errors import DeviceStateError
from platform_daemon.core.schemas.rpc import RpcCall
from platform_daemon.core.schemas.stop import StopReport
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.flag_file import FlagFile

from .address import NAME, connected, folder_of
from .errors import HardwareAway, error_from_wire
from .framing import ALIVE, JsonLineConnection

log = structlog.get_logger()
PATIENCE_S = 60.0  # longer than outputs off of devices that do not answer takes
SILENT_S = 2.0  # one that lives answers within milliseconds, under any load that was measured within 0.3 s
AWAY_S = 15.0  # longer than the hardware process takes to be back
_LOOK_S, _AGAIN_S = 0.3, 0.05
_MARK = "stop-asked"
STOPPED = "everything was stopped"
"""Why schedules are paused then."""


class StoppedMeanwhile(DeviceStateError):
    """A job that was requested before a stop is not made after it."""

    title = "Stopped meanwhile"


def stop_mark(folder: Path) -> FlagFile:
    """Flag of a data folder: no process answered a stop, so jobs that wait must not begin."""
    return FlagFile(folder / _MARK)


class Hangs(Exception):
    """The process that owns the hardware does not answer, and was killed."""


class Stopper:
    """Asks the process that owns the hardware to switch off, and the next one where that one is away.

    One that is silent for `silent_s` is killed: its guard sees that at once and switches off what has power, sooner
    than by its lease.  away_s: how long to wait while no process answers.  For any number of threads.

    It opens the folder when it is made, so it reaches the socket even if the folder is moved or its disk removed.
    """

    def __init__(self, folder: Path, silent_s: float = SILENT_S, away_s: float = AWAY_S) -> None:
        self._flag, self._path = stop_mark(folder), folder / NAME
        self._silent_s, self._away_s = silent_s, away_s
        self._folder_fd: int | None = None
        with contextlib.suppress(OSError):
            self._folder_fd = folder_of(self._path)
            weakref.finalize(self, os.close, self._folder_fd)

    def outputs_off(self) -> StopReport:
        """Switch everything off, proved by the process that owns the hardware, and cancel jobs that move or wait.

        It is repeated until a process has confirmed it, for `away_s` at most.  The flag keeps waiting jobs from
        beginning in a process that is started meanwhile.  Raises what the owner raises; HardwareAway if no process has
        confirmed it.
        """
        until, hung = time.monotonic() + self._away_s, False
        while True:
            try:
                report = self._request_outputs_off(hung=hung)
            except Hangs:
                hung, why = True, f"it was silent for {self._silent_s:g} s and was ended"
            except (OSError, ValueError) as error:
                why = str(error) or type(error).__name__
            else:
                self._flag.clear()  # also that of an earlier stop, which is now done
                return report
            with contextlib.suppress(StorageError):  # the loop tries again anyway
                self._flag.set()
            if time.monotonic() > until:
                raise _unconfirmed(why, self._away_s)
            time.sleep(_AGAIN_S)

    def _request_outputs_off(self, *, hung: bool) -> StopReport:
        """One request over the socket.  hung: an earlier process was killed because it hung.

        Raises Hangs, OSError, ValueError, and what the owner raises.
        """
        with contextlib.closing(JsonLineConnection(self._connected(PATIENCE_S))) as line:
            owner = line.peer()
            try:
                line.send(RpcCall(method="outputs_off", arguments=()))
                self._wait(line, owner)
            finally:
                if owner is not None:
                    os.close(owner)
            answer = line.answer()
        if answer is None:
            raise ConnectionError("it ended before it answered")
        if answer.error is not None:
            raise error_from_wire(answer.error)
        report = StopReport.model_validate(answer.value)
        return _after_a_hang(report) if hung else report

    def _connected(self, timeout_s: float) -> socket.socket:
        """Raises OSError."""
        try:
            return connected(self._path, timeout_s)
        except OSError:
            if self._folder_fd is None:
                raise
            return connected(self._path, timeout_s, self._folder_fd)

    def _wait(self, line: JsonLineConnection, owner: int | None) -> None:
        """Until it answers; switching off may take as long as its devices do, if only the process itself lives."""
        until = time.monotonic() + PATIENCE_S
        while not line.has_said(_LOOK_S):
            if not self._is_alive() and not line.has_said(0):
                log.error("hardware_process_hangs", silent_s=self._silent_s)
                if owner is not None:
                    signal.pidfd_send_signal(owner, signal.SIGKILL)
                raise Hangs
            if time.monotonic() > until:
                raise TimeoutError(f"it lives and has not answered for {PATIENCE_S:g} s")

    def _is_alive(self) -> bool:
        """Does it answer anything at all?  Another thread of it does than that which switches off."""
        left_s = self._silent_s - _LOOK_S
        try:
            with contextlib.closing(JsonLineConnection(self._connected(left_s))) as line:
                line.send(RpcCall(method=ALIVE, arguments=()))
                return line.has_said(left_s) and line.answer() is not None
        except (OSError, ValueError):
            return True  # it is ending; the other connection shows that as well


def _after_a_hang(report: StopReport) -> StopReport:
    said = "the hardware process hung and was killed, and the restarted one has proved it; a fault may be latched"
    return StopReport(status=f"{report.status}: {said}", hung=True)


def _unconfirmed(why: str, away_s: float) -> HardwareAway:
    remedy = (
        "look at the platform and GET /platform; if in doubt cut the amplifier's power, then ask again. "
        "A process that has died has a guard, which switches off; what waits is cancelled when the next one is there"
    )
    what = f"no hardware process has confirmed within {away_s:g} s that outputs are off"
    return HardwareAway(what, why=why, remedy=remedy)

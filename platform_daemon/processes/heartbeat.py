"""Heartbeats of a process to its parent: a process that hangs is as useless as a dead one.

A process that hangs while power may be on is ended by its guard.  Heartbeats are for all other processes.
"""

from __future__ import annotations

import os
import select
import threading
import time

HEARTBEAT = b"."
PERIOD_S = 0.5
TIMEOUT_S = 15.0  # a busy or swapping computer lets a thread that writes a byte wait for seconds, not for so long
_MAX_STEP_S = 2.0
_MAX_OUTPUT_BYTES = 4096


def start_heartbeat(pipe: int) -> None:
    """Send heartbeats from now on, in a thread of its own."""
    os.set_blocking(pipe, False)  # a parent that is halted must not halt this process
    threading.Thread(target=_send, args=(pipe,), name="heartbeat", daemon=True).start()


def _send(pipe: int) -> None:
    while True:
        try:
            os.write(pipe, HEARTBEAT)
        except BlockingIOError:
            pass
        except OSError:  # the parent has closed its end
            return
        time.sleep(PERIOD_S)


class HeartbeatMonitor:
    """The parent's end: how long the process has been silent.

    start_timeout_s: how long it may be silent before its first heartbeat, s.
    """

    def __init__(self, pipe: int, start_timeout_s: float) -> None:
        self._pipe = pipe
        self._start_timeout_s = start_timeout_s
        self._silent_s = 0.0
        self._checked_s = time.monotonic()
        self._started = False
        self._output = b""

    def started(self) -> None:
        """The process has started: from now on the ordinary time-out holds for the first heartbeat as well."""
        self._started = True

    def timed_out(self) -> bool:
        """Whether no heartbeat has come for too long; True once per time-out.  To be called every second.

        Only time in which the parent itself ran is counted, because a suspended computer suspends all processes.
        """
        now_s = time.monotonic()
        self._silent_s += min(now_s - self._checked_s, _MAX_STEP_S)
        self._checked_s = now_s
        received = self._receive()
        if received:
            self._silent_s = 0.0
            self._started = self._started or received.endswith(HEARTBEAT)
        if self._silent_s <= (TIMEOUT_S if self._started else self._start_timeout_s):
            return False
        self._silent_s = 0.0
        return True

    def last_output(self) -> bytes:
        """The last bytes that the process sent, heartbeats among them."""
        self._receive()
        return self._output

    def _receive(self) -> bytes:
        received = b""
        while select.select([self._pipe], [], [], 0)[0] and (part := os.read(self._pipe, 4096)):
            received += part
        self._output = (self._output + received)[-_MAX_OUTPUT_BYTES:]
        return received

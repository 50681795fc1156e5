"""What the guard does: it watches one process and switches the outputs off when that can no longer do it.

Run as `python -m platform_daemon.supervisor PID PLACE FD`: the owner, the folder of the lock, and the open file that
says who the owner is.  Standard input: the platform file's tables as one line of JSON, then one byte for each thing the
owner says.  The owner's death is seen by its pidfd, not by the end of the pipe, which
children of the owner may hold open.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from pathlib import Path

from .say import say

LEASE_S = 6.0  # unless the platform file says another; longer than any single answer of a device is waited for
OFF_LEASE_S = 30.0  # while outputs are being switched off, which has deadlines of its own
MAY_COME, ALIVE, SWITCHING_OFF, OFF, ENDED = b"+", b".", b"o", b"-", b"q"
READY = b"ready\n"
HEARD = b"+"
"""Answered to MAY_COME: a guard that is halted is none, and the pipe to it takes whatever is said."""


class Lease:
    """What the owner has said so far. due_s: until when (monotonic) it must say more, None: nothing is due."""

    def __init__(self, lease_s: float = LEASE_S) -> None:
        self.lease_s = lease_s
        self.due_s: float | None = None
        self.ended = False

    @property
    def power(self) -> bool:
        """Outputs are not known to be off."""
        return self.due_s is not None

    def heard(self, said: bytes, now_s: float) -> None:
        """Bytes of the owner, in their order."""
        for byte in said:
            word = bytes([byte])
            if word == MAY_COME or (word == ALIVE and self.power):
                self.due_s = now_s + self.lease_s
            elif word == SWITCHING_OFF and self.power:
                self.due_s = now_s + OFF_LEASE_S
            elif word == OFF:
                self.due_s = None
            elif word == ENDED:
                self.due_s, self.ended = None, True


def main() -> int:
    """Watch until the owner has ended; then, unless its outputs are known to be off, switch them off."""
    # The end of the owner is what counts; a terminal that closes or a service that stops must not end its guard first.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    try:
        owner = os.pidfd_open(int(sys.argv[1]))
    except ProcessLookupError:
        return 0  # it ended before it could let any power out
    from drivers.clock import SystemClock
    from drivers.outputs_off import output_backends
    from drivers.registry import PlatformSection
    from drivers.urgency import be_urgent

    from .lock_file import Cause
    from .ownership import Ownership
    from .rescue import rescue

    section = PlatformSection.model_validate_json(_line(sys.stdin.fileno()))
    output_backends(section)  # imported now, not when every millisecond counts
    be_urgent(SystemClock())  # once nothing is left that takes the processor from the shot
    with contextlib.suppress(BrokenPipeError):  # the devices have been let go already
        os.write(sys.stdout.fileno(), READY)
    lease = Lease(section.guard.lease_s)
    hung = _watch(owner, sys.stdin.fileno(), lease)
    if not lease.power:
        return 0
    ownership, cause = Ownership(int(sys.argv[3])), Cause.HUNG if hung else Cause.DIED
    return 0 if rescue(section, Path(sys.argv[2]), int(sys.argv[1]), cause, ownership) else 1


def _watch(owner: int, pipe: int, lease: Lease) -> bool:
    """Until the owner has ended or let its devices go; one that hangs while power may come is killed: True."""
    hung = False
    poll = select.poll()
    poll.register(owner, select.POLLIN)
    poll.register(pipe, select.POLLIN)
    while True:
        left_s = None if lease.due_s is None else max(0.0, lease.due_s - time.monotonic())
        ready = [number for number, _ in poll.poll(None if left_s is None else 1e3 * left_s + 1.0)]
        if pipe in ready:
            said = os.read(pipe, 4096)
            lease.heard(said, time.monotonic())
            with contextlib.suppress(OSError):  # the owner has died: its pidfd says so, too
                os.write(sys.stdout.fileno(), HEARD * said.count(MAY_COME))
            if lease.ended:
                return hung
            if not said:
                poll.unregister(pipe)
        elif owner in ready:  # all it has said has been read
            return hung
        elif lease.due_s is not None and time.monotonic() >= lease.due_s:
            hung = True
            say("owner_hangs_while_power_may_come", owner=int(sys.argv[1]))
            signal.pidfd_send_signal(owner, signal.SIGKILL)
            lease.due_s = time.monotonic() + lease.lease_s


def _line(pipe: int) -> bytes:
    """The first line, and not a byte more."""
    line = bytearray()
    while (byte := os.read(pipe, 1)) not in (b"\n", b""):
        line += byte
    return bytes(line)

"""The guard: it watches one process and switches the outputs off when that process can no longer do it.

Run as `python -m platform_daemon.core.guard PID DIRECTORY FD`: the owner, the directory of the fault latch, and the
open file that says who the owner is.  Standard input: the platform file's tables as one line of JSON, then one byte for
each message of the owner.  The owner's death is seen by its pidfd, not by the end of the pipe, which children of the
owner may hold open.

While power may be on the owner holds a lease of T seconds (`guard.lease_s`): each MAY_COME or ALIVE at time t sets the
instant t + T by which the next message is due.  An owner that is late is killed, and the outputs are switched off.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from pathlib import Path

from .stderr_log import log_event

LEASE_S = 6.0  # default of the platform file; longer than the time-out of any single answer of a device
OFF_LEASE_S = 30.0  # while outputs are being switched off, which has deadlines of its own
MAY_COME, ALIVE, SWITCHING_OFF, OFF, ENDED = b"+", b".", b"o", b"-", b"q"
READY = b"ready\n"
HEARD = b"+"
"""The answer to MAY_COME: the pipe to a halted guard accepts messages too, but they are not read."""


class Lease:
    """The messages of the owner so far.  due_s: the instant (monotonic) by which the next is due, None: none is."""

    def __init__(self, lease_s: float = LEASE_S) -> None:
        self.lease_s = lease_s
        self.due_s: float | None = None
        self.ended = False

    @property
    def power(self) -> bool:
        """The outputs are not known to be off."""
        return self.due_s is not None

    def heard(self, received: bytes, now_s: float) -> None:
        """Take messages of the owner, in their order; now_s: monotonic."""
        for byte in received:
            word = bytes([byte])
            if word == MAY_COME or (word == ALIVE and self.power):
                self.due_s = now_s + self.lease_s
            elif word == SWITCHING_OFF and self.power:
                self.due_s = now_s + OFF_LEASE_S
            elif word == OFF:
                self.due_s = None
            elif word == ENDED:
                self.due_s = None
                self.ended = True


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
    from drivers.realtime import set_realtime_priority
    from drivers.registry import PlatformSection

    from .emergency_off import switch_off_for_dead_owner
    from .fault_latch import Cause
    from .ownership import Ownership

    section = PlatformSection.model_validate_json(_line(sys.stdin.fileno()))
    output_backends(section)  # imported now, not when every millisecond counts
    set_realtime_priority(SystemClock())  # once nothing is left that takes the processor from the shot
    with contextlib.suppress(BrokenPipeError):  # the devices have been released already
        os.write(sys.stdout.fileno(), READY)
    lease = Lease(section.guard.lease_s)
    hung = _watch(owner, sys.stdin.fileno(), lease)
    if not lease.power:
        return 0
    proved = switch_off_for_dead_owner(
        section,
        state_dir=Path(sys.argv[2]),
        owner=int(sys.argv[1]),
        cause=Cause.HUNG if hung else Cause.DIED,
        ownership=Ownership(int(sys.argv[3])),
    )
    return 0 if proved else 1


def _watch(owner: int, pipe: int, lease: Lease) -> bool:
    """Watch until the owner has ended or released its devices.  True: it hung while power might come; it was killed."""
    hung = False
    poll = select.poll()
    poll.register(owner, select.POLLIN)
    poll.register(pipe, select.POLLIN)
    while True:
        left_s = None if lease.due_s is None else max(0.0, lease.due_s - time.monotonic())
        ready = [number for number, _ in poll.poll(None if left_s is None else 1e3 * left_s + 1.0)]
        if pipe in ready:
            received = os.read(pipe, 4096)
            lease.heard(received, time.monotonic())
            with contextlib.suppress(OSError):  # the owner has died; its pidfd shows that as well
                os.write(sys.stdout.fileno(), HEARD * received.count(MAY_COME))
            if lease.ended:
                return hung
            if not received:
                poll.unregister(pipe)
        elif owner in ready:  # all its messages have been read
            return hung
        elif lease.due_s is not None and time.monotonic() >= lease.due_s:
            hung = True
            log_event("owner_hangs_while_power_may_come", owner=int(sys.argv[1]))
            signal.pidfd_send_signal(owner, signal.SIGKILL)
            lease.due_s = time.monotonic() + lease.lease_s


def _line(pipe: int) -> bytes:
    """The first line, and not a byte more."""
    line = bytearray()
    while (byte := os.read(pipe, 1)) not in (b"\n", b""):
        line += byte
    return bytes(line)

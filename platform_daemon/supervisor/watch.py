"""What the guard does: it watches one process and switches the outputs off when that can no longer do it.

Run as `python -m platform_daemon.supervisor PID`; standard input: the platform file's tables as one line of JSON,
then one byte for each thing the owner says.  The owner's death is seen by its pidfd, not by the end of the pipe, which
children of the owner may hold open.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import sys
import time

LEASE_S = 6.0  # longer than any single answer of a device is waited for
OFF_LEASE_S = 30.0  # while outputs are being switched off, which has deadlines of its own
MAY_COME, ALIVE, SWITCHING_OFF, OFF, ENDED = b"+", b".", b"o", b"-", b"q"
READY = b"ready\n"
_TRIES_S = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 10.0)


class Lease:
    """What the owner has said so far. due_s: until when (monotonic) it must say more, None: nothing is due."""

    def __init__(self) -> None:
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
                self.due_s = now_s + LEASE_S
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
    from drivers.outputs_off import output_backends, switch_outputs_off
    from drivers.registry import PlatformSection

    section = PlatformSection.model_validate_json(_line(sys.stdin.fileno()))
    output_backends(section)  # imported now, not when every millisecond counts
    with contextlib.suppress(BrokenPipeError):  # the devices have been let go already
        os.write(sys.stdout.fileno(), READY)
    lease = Lease()
    _watch(owner, sys.stdin.fileno(), lease)
    if not lease.power:
        return 0
    began = time.monotonic()
    for wait_s in _TRIES_S:
        time.sleep(wait_s)
        try:
            switch_outputs_off(section)
        except Exception as error:  # whatever it is: tried again
            _say("outputs_unconfirmed", error=str(error))
        else:
            _say(
                "outputs_switched_off_for_a_dead_owner",
                owner=int(sys.argv[1]),
                seconds=round(time.monotonic() - began, 3),
            )
            return 0
    return 1


def _watch(owner: int, pipe: int, lease: Lease) -> None:
    """Until the owner has ended or let its devices go; one that hangs while power may come is killed."""
    poll = select.poll()
    poll.register(owner, select.POLLIN)
    poll.register(pipe, select.POLLIN)
    while True:
        left_s = None if lease.due_s is None else max(0.0, lease.due_s - time.monotonic())
        ready = [number for number, _ in poll.poll(None if left_s is None else 1e3 * left_s + 1.0)]
        if pipe in ready:
            said = os.read(pipe, 4096)
            lease.heard(said, time.monotonic())
            if lease.ended:
                return
            if not said:
                poll.unregister(pipe)
        elif owner in ready:  # all it has said has been read
            return
        elif lease.due_s is not None and time.monotonic() >= lease.due_s:
            _say("owner_hangs_while_power_may_come", owner=int(sys.argv[1]))
            signal.pidfd_send_signal(owner, signal.SIGKILL)
            lease.due_s = time.monotonic() + LEASE_S


def _line(pipe: int) -> bytes:
    """The first line, and not a byte more."""
    line = bytearray()
    while (byte := os.read(pipe, 1)) not in (b"\n", b""):
        line += byte
    return bytes(line)


def _say(event: str, **more: object) -> None:
    """A line of JSON where the owner's log goes."""
    os.write(sys.stderr.fileno(), (json.dumps({"event": event, **more}) + "\n").encode())

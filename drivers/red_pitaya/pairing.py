"""Getting through to RedPitayaDAQServer, whoever is in the way, and proving that both sockets are ours.

The server accepts a command connection, ends its last client, and takes the oldest waiting data connection for this
one's, whoever made it.  Seen on the real server:

* Half open: a client died between its two connections.  The next data connection is paired with the dead client and
  closed at once, so the data socket is connected first and must live for a while.
* A stranger's command connection: ours is the data connection that it waits for, and goes with it.  The server then
  waits for one that belongs to our command connection.
* A stranger's data connection (a port scan) is taken for ours, and everybody gets the one of the client before.  An
  upload does not show that: the server answers it with success.  A short read does: its samples must arrive here.
  Another command connection takes the next data connection, until it is ours.
* A client that closes and connects again at once can hang the server for good: two of its threads end the same third
  one.  So nothing is closed here before the connection after it has been answered.
* A server that stands still for some seconds meets all who came meanwhile at once, and hangs in the same way if one of
  them has gone.  So a pair that it does not answer stays open, and is what the next attempt waits for.  Each second
  attempt is made with a new one: what the old ones wait for may be lost.
"""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Sequence

from drivers.errors import DeviceError, DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.red_pitaya.connection import Connection
from drivers.red_pitaya.ports import Unanswered, ask_anew, connect, notice_its_end, said_within
from drivers.red_pitaya.stream import PAIR_BYTES

HALF_OPEN_S = 0.3  # a half-open server closes the data socket within this time; ending a client takes it as long
ATTEMPTS = 4
QUEUE_S = 1.2  # a port whose queue is full does not answer; a second try after a second is included
QUEUE = 4  # more connections than wait at a port
TAKE_OVER_S = 3.0  # no new attempt after that: somebody waits to hear that the card is gone, and will try again
LAST_WORD_S = 0.2  # a client that is thrown out is closed, and one that is served has its answer, within this time
ENDING_S = 0.2  # the server ends a client that died in a recording when that is over, and needs less for it
EARLY_S = 0.03  # the end of a recording is known no better
PROOF_SAMPLES = 16
PROOF_S = 0.5

Pair = tuple[socket.socket, socket.socket]  # command and data

UNSERVED = 4  # pairs; where a server stands still two wait at its ports, so one with more of them has taken some
_UNSERVED: dict[tuple[str, tuple[int, int]], list[Pair]] = {}
"""By address, what its server has not answered yet, for whoever tries again in this process."""


def open_pair(
    host: str, ports: tuple[int, int], timeout_s: float, off: Sequence[str], until_s: float = math.inf
) -> Connection:
    """Connect to a server in whatever state it is; no new attempt from `until_s` (monotonic) on, but one at least.

    off: the commands that switch the outputs off, which are the first that are sent.  Where time is short that is what
    counts, and a pair on which no samples arrive will do (`Connection.whole`).  Raises DeviceNotFound if nothing
    listens, DeviceTimeout if it does not answer, DeviceLost if it hangs up each time, DeviceProtocolError if it, or its
    data port, is something else.
    """
    error: DeviceError = _silent(host, ports)
    held: list[socket.socket] = []
    try:
        for attempt in range(ATTEMPTS):
            if attempt and time.monotonic() >= until_s:
                break
            try:
                return _attempt(attempt, host, ports, timeout_s, off, held, until_s)
            except DeviceTimeout:
                error = error if isinstance(error, DeviceProtocolError) else _silent(host, ports)
            except Unanswered:
                if not attempt:  # else those before it wait to be taken
                    raise
            except _HalfOpen:
                continue
            except DeviceLost as failure:  # a slow card still ends the client before, and closed this one with it
                error = error if isinstance(error, DeviceProtocolError) else failure
                time.sleep(HALF_OPEN_S)
            except DeviceProtocolError as failure:
                error = failure
    finally:
        for each in held:
            each.close()
    time.sleep(HALF_OPEN_S)  # whoever tries again comes when the server has ended all of these
    raise error


def take_over(old: Connection, host: str, ports: tuple[int, int], timeout_s: float, off: Sequence[str]) -> Connection:
    """A new pair in place of `old`, which is closed: the server zeroes the outputs at once.

    The new pair is connected first.  If that is not answered, the server may be waiting for bytes of the old one, which
    is told that none will come, and it is tried as in `open_pair`, with the same errors, but for some TAKE_OVER_S only.
    If it is not answered at all, the old one stays open as well: a server that goes on and finds both its client gone
    and another one there hangs.  If the old one is gone already, the outputs are zero, and the server may be half open
    for whoever came: that takes more patience.
    Whoever comes between that question and the new pair, 1 ms later, can still hang the server.
    """
    until_s = time.monotonic() + TAKE_OVER_S
    held: list[socket.socket] = []
    try:
        if _UNSERVED.get((host, ports)):
            return open_pair(host, ports, timeout_s, off, until_s)
        if not old.answers(LAST_WORD_S) and old.evicted():
            old.close()
            ask_anew(host)  # it may have been off and on
            return open_pair(host, ports, timeout_s, off, until_s)
        try:
            return _prove(host, ports, timeout_s, off, _data_connection(host, ports, held), held, until_s)
        except DeviceError:
            old.abandon()
            time.sleep(HALF_OPEN_S)
            return open_pair(host, ports, timeout_s, off, until_s)
    finally:
        if not _UNSERVED.get((host, ports)):
            old.close()
        for each in held:
            each.close()


def keep_clear(recording_until_s: float) -> None:
    """Call it before `open_pair`: its command connection will not come while the server ends a client that has died.

    That happens when the recording is over that the client had asked for, and whoever comes then finds the server
    hung, or loses the connection at once.  Somebody who comes before that is safe: the server ends both itself.
    """
    wait_s = recording_until_s + ENDING_S - HALF_OPEN_S - time.monotonic()
    if 0 < wait_s < ENDING_S + EARLY_S:
        time.sleep(wait_s)


class _HalfOpen(Exception):
    """The server paired the data connection with a client that is dead."""


def _attempt(
    attempt: int,
    host: str,
    ports: tuple[int, int],
    timeout_s: float,
    off: Sequence[str],
    held: list[socket.socket],
    until_s: float,
) -> Connection:
    """With a pair that waits to be served, which has the first attempt and each second one after it, or a new one."""
    waiting = _UNSERVED.get((host, ports), [])
    if waiting and attempt % 2 == 0:
        command, data = waiting.pop()
        return _prove(host, ports, timeout_s, off, data, held, until_s, command)
    # Where others wait, nobody must be sent to the command port alone to make room: that one would go again.
    data = connect(host, ports[1], QUEUE_S) if waiting else _data_connection(host, ports, held)
    while len(waiting) >= UNSERVED:
        held += waiting.pop(0)
    said = said_within(data, HALF_OPEN_S)
    if said is not None:
        data.close()
    if said:
        raise _foreign(f"{host}:{ports[1]}", f"it says {said!r} unasked")
    if said == b"":
        time.sleep(HALF_OPEN_S)
        raise _HalfOpen
    return _prove(host, ports, timeout_s, off, data, held, until_s)


def _data_connection(host: str, ports: tuple[int, int], held: list[socket.socket]) -> socket.socket:
    """A data connection, also if strangers fill the queue of that port: each command connection takes one of them."""
    for _ in range(QUEUE):
        try:
            return connect(host, ports[1], QUEUE_S)
        except Unanswered:
            held.append(connect(host, ports[0]))
    return connect(host, ports[1])


def _prove(
    host: str,
    ports: tuple[int, int],
    timeout_s: float,
    off: Sequence[str],
    data: socket.socket,
    held: list[socket.socket],
    until_s: float,
    waiting: socket.socket | None = None,
) -> Connection:
    """Command connections, one after the other, until one has this data connection; the others go into `held`.

    until_s: as in `open_pair`; waiting: the first of them, which has sent its mark already.
    """
    where, ours = f"{host}:{ports[1]}", False
    try:
        for tries in range(1, QUEUE + 1):
            command, asked, waiting = waiting or connect(host, ports[0]), waiting is not None, None
            held.append(command)
            connection = Connection(command, data, f"{host}:{ports[0]}", timeout_s)
            try:
                connection.synchronise(asked=asked)
            except DeviceTimeout:
                if said_within(data, 0.0) != b"":
                    held.remove(command)
                    for each in (command, data):
                        notice_its_end(each, from_now_on=True)
                    _UNSERVED.setdefault((host, ports), []).append((command, data))
                    raise
                ours = tries > 1  # with the client before it went what that one had, and no samples had arrived
                data.close()
                data = connect(host, ports[1], QUEUE_S)
                connection = Connection(command, data, f"{host}:{ports[0]}", timeout_s)
                connection.synchronise(asked=True)
            connection.ask_all(off)
            said = said_within(data, 0.0)
            if said == b"" and not connection.answers(LAST_WORD_S):
                raise connection.lost("it closed both sockets")
            if said is not None:
                raise _foreign(where, f"it says {said!r} unasked")
            if _samples_arrive(connection):
                held.remove(command)
                for each in (command, data):
                    notice_its_end(each, from_now_on=False)
                for pair in _UNSERVED.pop((host, ports), []):  # the server has thrown them out by now
                    held += pair
                return connection
            if ours or time.monotonic() >= until_s:
                break
        if until_s < math.inf:
            held.remove(command)
            connection.give_up_data(_no_samples(where, tries))
            return connection
    except DeviceError:
        if not any(data in pair for pair in _UNSERVED.get((host, ports), [])):
            data.close()
        raise
    data.close()
    raise _no_samples(where, tries)


def _samples_arrive(connection: Connection) -> bool:
    """A short read, which needs no trigger.  Leaves the server in mode ACQUISITION."""
    connection.ask_all(["RP:MODE ACQUISITION", f"RP:ADC:DATA? 0,{PROOF_SAMPLES}"])
    try:
        connection.receive_into(memoryview(bytearray(PROOF_SAMPLES * PAIR_BYTES)), PROOF_S)
    except DeviceTimeout:
        return False
    return True


def _silent(host: str, ports: tuple[int, int]) -> DeviceTimeout:
    return DeviceTimeout(
        "the card does not answer",
        where=f"{host}:{ports[0]}",
        why="its DAQ server takes the connection and says nothing: it hangs, or waits for another program that is "
        f"connected to its data port, or its data port is not {ports[1]}",
        remedy="correct io_card.boards.data_port, end that program, or restart the card's DAQ server (or the card)",
    )


def _no_samples(where: str, tries: int) -> DeviceProtocolError:
    return _foreign(where, f"of {PROOF_SAMPLES} samples that were asked for {tries} times none arrived")


def _foreign(where: str, why: str) -> DeviceProtocolError:
    return DeviceProtocolError(
        "the data port is not that of the card",
        where=where,
        why=why,
        remedy="correct io_card.boards.data_port, or end the programs that are connected to it",
    )

"""Connects to RedPitayaDAQServer past other clients, and proves that both sockets belong to one client of it.

The server accepts a command connection, ends its former client, and takes the oldest waiting data connection as that of
the new client, whichever program opened it.  Cases seen on the real server:

* Half open: a client died between its two connections.  The next data connection is paired with the dead client and
  closed at once.  So the data socket is connected first, and must stay open for a while.
* A foreign command connection takes our waiting data connection, which is closed with it.  The server then waits for a
  data connection that belongs to our command connection.
* A foreign data connection (a port scan) is taken as ours, and each client gets the data connection of the one before.
  An upload does not reveal that, because the server reports success.  A short read does: its samples must arrive here.
  Each further command connection takes the next data connection, until it is the right one.
* A client that closes and connects again at once can hang the server for good, because two of its threads end the same
  third one.  So nothing is closed here before the connection after it has been answered.
* A server that is halted for some seconds then meets all connections that were made meanwhile, and hangs in the same
  way if one of them has been closed.  So a pair that is not answered stays open, and the next attempt waits for it.
  Each second attempt opens a new pair, because the old ones may wait for something that never comes.
"""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Sequence
from dataclasses import dataclass

from drivers.errors import DeviceError, DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.red_pitaya.connection import Connection
from drivers.red_pitaya.ports import CONNECT_S, Unanswered, connect, forget_address, peek, set_keepalive
from drivers.red_pitaya.stream import PAIR_BYTES

HALF_OPEN_S = 0.3  # a half-open server closes the data socket within this time; ending a client takes it as long
ATTEMPTS = 4
QUEUE_S = 1.2  # a port whose queue is full does not answer; a second try after a second is included
QUEUE = 4  # more connections than wait at a port
TAKE_OVER_S = 3.0  # no new attempt after that: the caller waits for the error, and tries again
ANSWER_S = 0.2  # within this time the server closes a former client, or answers a present one
ENDING_S = 0.2  # the server ends a client that died in a recording when that is over, and needs less for it
EARLY_S = 0.03  # how exactly the end of a recording is known
PROOF_SAMPLES = 16
PROOF_S = 0.5

Pair = tuple[socket.socket, socket.socket]  # command and data

UNSERVED = 4  # pairs; two wait at the ports of a halted server, so one with more of them has accepted some
_UNSERVED: dict[tuple[str, tuple[int, int]], list[Pair]] = {}
"""Pairs by address that the server has not answered yet, for the next attempt of this process."""


@dataclass(frozen=True, kw_only=True)
class _Card:
    """Where to connect: command and data port; timeout_s: of the connection; off: commands that are sent first."""

    host: str
    ports: tuple[int, int]
    timeout_s: float
    off: Sequence[str]

    @property
    def address(self) -> tuple[str, tuple[int, int]]:
        """Key of `_UNSERVED`."""
        return self.host, self.ports

    def command(self) -> socket.socket:
        """A command connection."""
        return connect(self.host, self.ports[0])

    def data(self, timeout_s: float = CONNECT_S) -> socket.socket:
        """A data connection."""
        return connect(self.host, self.ports[1], timeout_s)

    def connection(self, command: socket.socket, data: socket.socket) -> Connection:
        """The two as one client."""
        return Connection(command, data, f"{self.host}:{self.ports[0]}", self.timeout_s)


def open_pair(
    host: str, ports: tuple[int, int], timeout_s: float, off: Sequence[str], deadline_s: float = math.inf
) -> Connection:
    """Connect to a server in any state.  At least one attempt, and no new one after `deadline_s` (monotonic).

    off: the commands that switch the outputs off, which are sent first.  With a deadline they are what counts, and a
    pair on which no samples arrive is returned, too (`Connection.whole`).  Raises DeviceNotFound if nothing
    listens, DeviceTimeout if it does not answer, DeviceLost if it hangs up each time, DeviceProtocolError if it, or its
    data port, is something else.
    """
    card = _Card(host=host, ports=ports, timeout_s=timeout_s, off=off)
    return _open(card, deadline_s)


def _open(card: _Card, deadline_s: float) -> Connection:
    """See `open_pair`."""
    error: DeviceError = _silent(card)
    held: list[socket.socket] = []
    try:
        for attempt in range(ATTEMPTS):
            if attempt and time.monotonic() >= deadline_s:
                break
            try:
                return _attempt(card, held, deadline_s, attempt=attempt)
            except DeviceTimeout:
                error = error if isinstance(error, DeviceProtocolError) else _silent(card)
            except Unanswered:
                if not attempt:  # otherwise earlier connections still wait to be accepted
                    raise
            except _HalfOpen:
                continue
            except DeviceLost as failure:  # a slow card was still ending the former client, and closed this one with it
                error = error if isinstance(error, DeviceProtocolError) else failure
                time.sleep(HALF_OPEN_S)
            except DeviceProtocolError as failure:
                error = failure
    finally:
        for each in held:
            each.close()
    time.sleep(HALF_OPEN_S)  # so that the server has ended all of these before the next attempt
    raise error


def take_over(old: Connection, host: str, ports: tuple[int, int], timeout_s: float, off: Sequence[str]) -> Connection:
    """A new pair in place of `old`, which is closed: the server zeroes the outputs at once.

    The new pair is connected first.  If it is not answered, the server may be waiting for bytes of the old one, which
    is then informed that none will come, and connecting continues as in `open_pair`, with the same errors, for about
    TAKE_OVER_S.  If it is never answered, the old one stays open as well, because a server that resumes and finds its
    client closed and another one waiting hangs.  If the old one has been closed by the server, the outputs are zero,
    and the server may be half open for another client, which takes more patience.
    A client that connects in the 1 ms between the question to the old connection and the new pair can still hang the
    server.
    """
    card = _Card(host=host, ports=ports, timeout_s=timeout_s, off=off)
    deadline_s = time.monotonic() + TAKE_OVER_S
    held: list[socket.socket] = []
    try:
        if _UNSERVED.get(card.address):
            return _open(card, deadline_s)
        if not old.answers(ANSWER_S) and old.evicted():
            old.close()
            forget_address(host)  # the card may have been switched off and on
            return _open(card, deadline_s)
        try:
            return _prove(card, _data_connection(card, held), held, deadline_s)
        except DeviceError:
            old.abandon()
            time.sleep(HALF_OPEN_S)
            return _open(card, deadline_s)
    finally:
        if not _UNSERVED.get(card.address):
            old.close()
        for each in held:
            each.close()


def keep_clear(recording_until_s: float) -> None:
    """Wait before `open_pair`, so that it does not connect while the server is ending a client that has died.

    The server ends such a client when its recording is over.  A client that connects just then finds the server hung,
    or loses the connection at once; one that connects earlier is safe.
    """
    wait_s = recording_until_s + ENDING_S - HALF_OPEN_S - time.monotonic()
    if 0 < wait_s < ENDING_S + EARLY_S:
        time.sleep(wait_s)


class _HalfOpen(Exception):
    """The server paired the data connection with a client that is dead."""


def _attempt(
    card: _Card,
    held: list[socket.socket],
    deadline_s: float,
    *,
    attempt: int,
) -> Connection:
    """One attempt: the first and each second one with a pair that waits to be served, if any, else with a new pair."""
    waiting = _UNSERVED.get(card.address, [])
    if waiting and attempt % 2 == 0:
        command, data = waiting.pop()
        return _prove(card, data, held, deadline_s, waiting=command)
    # While pairs wait, no lone command connection may be used to make room: it would be closed again.
    data = card.data(QUEUE_S) if waiting else _data_connection(card, held)
    while len(waiting) >= UNSERVED:
        held += waiting.pop(0)
    received = peek(data, HALF_OPEN_S)
    if received is not None:
        data.close()
    if received:
        raise _foreign(f"{card.host}:{card.ports[1]}", f"it says {received!r} unasked")
    if received == b"":
        time.sleep(HALF_OPEN_S)
        raise _HalfOpen
    return _prove(card, data, held, deadline_s)


def _data_connection(card: _Card, held: list[socket.socket]) -> socket.socket:
    """A data connection, also if foreign ones fill the queue of the port: each command connection takes one of them."""
    for _ in range(QUEUE):
        try:
            return card.data(QUEUE_S)
        except Unanswered:
            held.append(card.command())
    return card.data()


def _prove(
    card: _Card,
    data: socket.socket,
    held: list[socket.socket],
    deadline_s: float,
    *,
    waiting: socket.socket | None = None,
) -> Connection:
    """Open command connections, one after the other, until one has this data connection; the others go into `held`.

    deadline_s: as in `open_pair`; waiting: a command connection to begin with, on which `*IDN?` was sent already.
    """
    where = f"{card.host}:{card.ports[1]}"
    ours = False
    try:
        for tries in range(1, QUEUE + 1):
            command = waiting or card.command()
            mark_sent = waiting is not None
            waiting = None
            held.append(command)
            connection = card.connection(command, data)
            try:
                connection.synchronise(mark_sent=mark_sent)
            except DeviceTimeout:
                if peek(data, 0.0) != b"":
                    held.remove(command)
                    for each in (command, data):
                        set_keepalive(each, on=True)
                    _UNSERVED.setdefault(card.address, []).append((command, data))
                    raise
                # The former client was closed with its data connection, on which no samples had arrived.
                ours = tries > 1
                data.close()
                data = card.data(QUEUE_S)
                connection = card.connection(command, data)
                connection.synchronise(mark_sent=True)
            connection.ask_all(card.off)
            _refuse_unasked(connection, data, where)
            if _samples_arrive(connection):
                held.remove(command)
                for each in (command, data):
                    set_keepalive(each, on=False)
                for pair in _UNSERVED.pop(card.address, []):  # the server has disconnected them by now
                    held += pair
                return connection
            if ours or time.monotonic() >= deadline_s:
                break
        if deadline_s < math.inf:
            held.remove(command)
            connection.give_up_data(_no_samples(where, tries))
            return connection
    except DeviceError:
        if not any(data in pair for pair in _UNSERVED.get(card.address, [])):
            data.close()
        raise
    data.close()
    raise _no_samples(where, tries)


def _refuse_unasked(connection: Connection, data: socket.socket, where: str) -> None:
    """Raises DeviceLost if the server closed both sockets, DeviceProtocolError if bytes arrive without a request."""
    received = peek(data, 0.0)
    if received == b"" and not connection.answers(ANSWER_S):
        raise connection.lost("it closed both sockets")
    if received is not None:
        raise _foreign(where, f"it says {received!r} unasked")


def _samples_arrive(connection: Connection) -> bool:
    """A short read, which needs no trigger.  Leaves the server in mode ACQUISITION."""
    connection.ask_all(["RP:MODE ACQUISITION", f"RP:ADC:DATA? 0,{PROOF_SAMPLES}"])
    try:
        connection.receive_into(memoryview(bytearray(PROOF_SAMPLES * PAIR_BYTES)), PROOF_S)
    except DeviceTimeout:
        return False
    return True


def _silent(card: _Card) -> DeviceTimeout:
    return DeviceTimeout(
        "the card does not answer",
        where=f"{card.host}:{card.ports[0]}",
        why="its DAQ server takes the connection and says nothing: it hangs, or waits for another program that is "
        f"connected to its data port, or its data port is not {card.ports[1]}",
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

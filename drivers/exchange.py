"""Questions and answers over a wire that may break: one at a time, reopened and re-identified after any failure.

A wire (serial line, USB, TCP) only carries lines.  After a time-out a late answer could be taken for that of the next
question, and after a reconnect another device may be connected; so after a failed exchange the wire is opened again and
the identity is checked before anything else is sent.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Protocol

from drivers.errors import DeviceError, DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.identity import Identity


class Wire(Protocol):
    """Carries lines.  Raises DeviceTimeout, DeviceLost, DeviceProtocolError."""

    def send(self, text: str) -> None:
        """Send one line."""

    def receive(self) -> str:
        """The next line, without its end."""

    def close(self) -> None:
        """Close.  Idempotent."""


class Exchange:
    """The owner of a wire: any thread may ask, one question is on the wire at a time.

    identity: what `*IDN?` must contain, empty: anything; on_open: called after every opening, the first included, to
    bring the device into its safe state; a device may replace it.  last_words: commands that are sent when an exchange
    has failed, before the wire is opened again: they make a device safe that still receives but cannot be received.
    """

    last_words: tuple[str, ...] = ()

    def __init__(
        self,
        where: str,
        open_wire: Callable[[], Wire],
        identity: str = "",
        identify: str = "*IDN?",
        on_open: Callable[[Exchange], None] = lambda exchange: None,
    ) -> None:
        """Open the wire.  Raises DeviceNotFound, DeviceDenied, DeviceTimeout, DeviceProtocolError (another device)."""
        self.where = where
        self._open_wire = open_wire
        self._wanted = identity
        self._identify = identify
        self.on_open = on_open
        self._lock = threading.RLock()
        self._wire: Wire | None = None
        self._known: str | None = None
        self._closed = False
        with self._lock:
            self._opened()

    def ask(self, question: str) -> str:
        """The answer to one question.  Raises DeviceTimeout, DeviceLost, DeviceProtocolError."""
        with self._lock, self._failing_closed():
            wire = self._opened()
            wire.send(question)
            return self._no_echo(question, wire.receive())

    def tell(self, command: str) -> None:
        """Send a command that has no answer; errors as in `ask`."""
        with self._lock, self._failing_closed():
            self._opened().send(command)

    def identity(self) -> Identity:
        """Query the identity.  Raises also DeviceProtocolError if it is another device than before."""
        with self._lock:
            text = self.ask(self._identify)
            self._check(text)
        return parsed_identity(text)

    def close(self) -> None:
        """Close.  Idempotent."""
        with self._lock:
            self._closed = True
            self._drop()

    def _opened(self) -> Wire:
        if self._closed:
            raise DeviceLost("the device is closed", where=self.where, remedy="restart the daemon")
        if self._wire is None:
            self._wire = self._open_wire()
            try:
                self._wire.send(self._identify)
                self._check(self._no_echo(self._identify, self._first_answer(self._wire)))
                self.on_open(self)
            except Exception:
                self._drop()
                raise
        return self._wire

    def _first_answer(self, wire: Wire) -> str:
        """The identity.  A late answer from before the wire was reopened is discarded."""
        answer = wire.receive()
        if self._known is not None and answer != self._known:
            with contextlib.suppress(DeviceTimeout):
                answer = wire.receive()
        return answer

    def _no_echo(self, question: str, answer: str) -> str:
        """The answer.  Raises DeviceProtocolError for a device that repeats what it is asked."""
        if answer == question:
            raise DeviceProtocolError(
                f"the answer to {question!r} is the question itself",
                where=self.where,
                why="a device, or an adapter before it, sends back what it receives",
                remedy="switch its echo off, or check that the port is that of the device",
            )
        return answer

    def _check(self, text: str) -> None:
        if self._wanted not in text or (self._known is not None and text != self._known):
            raise DeviceProtocolError(
                "another device answers",
                where=self.where,
                why=f"it is {text[:80]!r}, not {self._known or self._wanted!r}",
                remedy="plug the right device in, or correct port and identity in the platform file",
            )
        self._known = text

    @contextlib.contextmanager
    def _failing_closed(self) -> Iterator[None]:
        """After a failure the wire is closed, so that the next exchange opens it again."""
        try:
            yield
        except DeviceError:
            self._say_last_words()
            self._drop()
            raise

    def _say_last_words(self) -> None:
        """Send `last_words` to a device that has been identified on this wire, until one cannot be sent."""
        if self._wire is not None:
            with contextlib.suppress(DeviceError):
                for words in self.last_words:
                    self._wire.send(words)

    def _drop(self) -> None:
        if self._wire is not None:
            self._wire.close()
            self._wire = None


def parsed_identity(text: str) -> Identity:
    """`maker,model,serial,firmware`; what is missing stays empty."""
    parts = [part.strip() for part in text.split(",")] + [""] * 4
    return Identity(*parts[:4])


@contextlib.contextmanager
def closed_on_error(exchange: Exchange) -> Iterator[Exchange]:
    """The exchange, closed again if what is done with it raises."""
    try:
        yield exchange
    except Exception:
        exchange.close()
        raise

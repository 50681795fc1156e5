"""How many connections there are, and how long one may say nothing.

uvicorn's own `limit_concurrency` lets every connection in, counts those that have said nothing as well as those that
wait for an answer, and answers 503 to whoever comes next: a thousand that say nothing keep everybody out.  Here a new
connection takes the place of the one that has said nothing for longest, and only where all are being answered it is
turned away.  One client has a share of them (`room.py`), and what is no plain HTTP ends them (`strict_http.py`).
"""

from __future__ import annotations

import asyncio
import functools
import socket

import h11
import uvicorn
from fastapi import FastAPI
from uvicorn.protocols.http.h11_impl import H11Protocol

from .callers import counted
from .certificates import Certificate
from .entrance import Entrance
from .limits import Limits
from .room import Room
from .strict_http import StrictConnection, refusal

UNREADABLE = refusal(
    400, "No HTTP", "What was sent is no request of HTTP/1.1", "use a program that speaks it; TLS needs https://"
)
TWO_LENGTHS = refusal(
    400,
    "Two lengths",
    "The request says with Transfer-Encoding and otherwise how long its body is, and two readers could take it for two "
    "different requests",
    "send Content-Length, or Transfer-Encoding: chunked of HTTP/1.1, and not both",
)
FULL = refusal(
    503,
    "Too many connections",
    "All connections are being answered",
    "ask again in a second; POST /stop has its own port",
)
YOUR_SHARE = refusal(
    503,
    "Too many connections of one client",
    "All connections that one address may have are being answered",
    "use connections again, or close some; POST /stop has its own port",
)
DRAINED = 16_000_000  # bytes of a body that nobody wants, read so that its sender sees the answer; then it is cut off
ACCEPTED_AT_ONCE = 50
"""asyncio accepts so many before it reads from any: of a crowd that comes at once nobody is dropped unheard, as long as
it is few against the number of connections."""
MOST_PENDING = 1024  # that the kernel keeps until they are accepted
LONGEST_HEAD = 32 * 1024  # bytes
MOST_UNREAD = 64 * 1024
"""Bytes of an answer that wait in memory for a client that does not read; asyncio has eight times that over TLS."""


class BoundedConfig(uvicorn.Config):
    """uvicorn's configuration with our limits, and what TLS is made with."""

    limits: Limits
    certificate: Certificate | None
    entrance: Entrance | None
    room: Room[BoundedProtocol]


class BoundedProtocol(H11Protocol):
    """One connection."""

    config: BoundedConfig
    conn: StrictConnection

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Make room for it, or turn it away."""
        super().connection_made(transport)
        transport.set_write_buffer_limits(MOST_UNREAD)
        if self.config.entrance is not None:
            self.config.entrance.let_in(transport.get_extra_info("socket"))
        self._deadline: asyncio.TimerHandle | None = None
        self._unread: asyncio.TimerHandle | None = None
        self._drained = 0
        self.conn = StrictConnection(h11.SERVER, LONGEST_HEAD)
        peer = transport.get_extra_info("peername")
        client = counted(peer[0]) if peer else ""
        room = self.config.room
        room.enter(self, client)
        if room.too_many_of(client) and not self._another_leaves(client):
            self._turn_away(YOUR_SHARE)
        elif room.too_many and not self._another_leaves(None):
            self._turn_away(FULL)
        else:
            room.unheard[self] = None
            self._expect_head()

    def _turn_away(self, why: bytes) -> None:
        self.transport.write(why)
        self.transport.close()
        longest = self.config.room.turn_away(self)
        if longest is not None:
            self.config.room.leave(longest)
            longest.transport.abort()

    @property
    def quiet(self) -> bool:
        """Is no request being answered here?"""
        return self.cycle is None or self.cycle.response_complete

    def data_received(self, data: bytes) -> None:
        """Watch that heads are whole in time, and that bodies which nobody reads end."""
        if self.transport.is_closing():
            return
        draining = self.cycle is not None and self.quiet and self.conn.their_state is h11.SEND_BODY
        self._drained = self._drained + len(data) if draining else 0
        if self._drained > DRAINED:
            self.transport.abort()
            return
        super().data_received(data)
        if self.quiet:
            self._expect_head()
        else:
            self._heard()
            self.config.room.leave_quiet(self)
        if not self.quiet and self.conn.their_state is h11.SEND_BODY:
            self.config.room.unfinished.setdefault(self)
        else:
            self.config.room.unfinished.pop(self, None)

    def send_400_response(self, msg: str) -> None:
        """What was sent is no HTTP, or not the same to everybody who reads it."""
        self.transport.write(TWO_LENGTHS if self.conn.has_two_lengths else UNREADABLE)
        self.transport.close()

    def on_response_complete(self) -> None:
        """From here on it is quiet again, unless the next request is there."""
        super().on_response_complete()
        if self.quiet:
            self.config.room.answered[self] = None
            self.config.room.unfinished.pop(self, None)
        if self.quiet and self.conn.their_state is h11.SEND_BODY:
            self._expect_head()

    def pause_writing(self) -> None:
        """The client does not read: it has some time to go on."""
        super().pause_writing()
        self._unread = self.loop.call_later(self.config.limits.stalled_s, self.transport.abort)

    def resume_writing(self) -> None:
        """The client reads again."""
        super().resume_writing()
        if self._unread is not None:
            self._unread.cancel()

    def connection_lost(self, exc: Exception | None) -> None:
        """No more timers."""
        self._heard()
        self.config.room.leave(self)
        if self._unread is not None:
            self._unread.cancel()
        super().connection_lost(exc)

    def _expect_head(self) -> None:
        if self._deadline is None:
            self._deadline = self.loop.call_later(self.config.limits.headers_s, self.transport.abort)

    def _heard(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _another_leaves(self, client: str | None) -> bool:
        """Close one, of a client or of anybody, that makes room; False: all are being answered."""
        longest = self.config.room.who_leaves(self, client)
        if longest is None:
            return False
        self.config.room.leave(longest)  # now, as `connection_lost` comes a turn of the loop later
        longest.transport.abort()
        return True


class BoundedServer(uvicorn.Server):
    """A server whose clients must also be done with TLS in time: before that no protocol has seen them."""

    config: BoundedConfig

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen."""
        loop = asyncio.get_running_loop()
        if self.config.certificate is not None:
            patience = self.config.limits.headers_s
            loop.create_server = functools.partial(loop.create_server, ssl_handshake_timeout=patience)  # type: ignore
            sockets = [self._entrance(listener) for listener in sockets or ()]
        await super().startup(sockets)
        for listener in sockets or ():
            listener.listen(MOST_PENDING)  # uvicorn has told the kernel what it tells asyncio

    def _entrance(self, listener: socket.socket) -> Entrance:
        self.config.entrance = Entrance(listener, self.config.limits)
        return self.config.entrance


def bounded_config(app: FastAPI, limits: Limits, certificate: Certificate | None = None) -> BoundedConfig:
    """uvicorn's configuration for an application; certificate: None for plain HTTP."""
    config = BoundedConfig(
        app,
        http=BoundedProtocol,
        loop="asyncio",
        ws="none",
        log_config=None,
        # It warns of every request that is none: whoever sends many would fill the disk with them.
        log_level="error",
        access_log=False,
        backlog=ACCEPTED_AT_ONCE,
        timeout_graceful_shutdown=3,
        h11_max_incomplete_event_size=LONGEST_HEAD,
        # A header must not tell where a client is: the audit log would believe it.
        proxy_headers=False,
        ssl_certfile=None if certificate is None else certificate.chain,
        ssl_keyfile=None if certificate is None else certificate.key,
    )
    config.limits, config.certificate, config.entrance = limits, certificate, None
    config.room = Room(limits)
    return config

"""A server on a socket of its own with small limits: what is refused, what is waited for, and what is dropped."""

import asyncio
import json
import socket
import ssl
import time
from contextlib import contextmanager, suppress

import pytest

from platform_daemon.core.web import problems
from platform_daemon.core.web.network.certificates import Certificate
from platform_daemon.core.web.network.http_server import running_server
from platform_daemon.core.web.network.limits import Limits
from platform_daemon.core.web.network.middleware import AdmissionMiddleware
from platform_daemon.core.web.network.policy import Network
from tests.kit.data import DATA

OURS = Certificate(DATA / "tls/localhost.pem", DATA / "tls/localhost.key")
REQUEST = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"
LATE = REQUEST.replace(b"/ ", b"/late ", 1)


async def answers(scope, receive, send):
    """Says ok, without reading a body; /big says 20 MB; /late after half a second; /body once the body is whole."""
    if scope["type"] != "http":
        return
    if scope["path"] == "/late":
        await asyncio.sleep(0.5)
    while scope["path"] == "/body":
        message = await receive()
        if message["type"] == "http.disconnect":
            return
        if not message.get("more_body"):
            break
    body = b"x" * 20_000_000 if scope["path"] == "/big" else b"ok"
    await send(
        {"type": "http.response.start", "status": 200, "headers": [(b"content-length", str(len(body)).encode())]}
    )
    await send({"type": "http.response.body", "body": body})


@contextmanager
def serving(certificate=None, max_connections=None, **limits):
    """A function that connects to a server of `answers`."""
    listener = socket.create_server(("127.0.0.1", 0))
    app = AdmissionMiddleware(answers, Network(), problems.respond)
    with running_server(
        app, listener, limits=Limits(**limits), certificate=certificate, max_connections=max_connections
    ):
        yield lambda: socket.create_connection(listener.getsockname(), 5)


def everything(link):
    return b"".join(iter(lambda: link.recv(1000), b""))


def is_closed(link, within_s):
    """Has the other end closed it by then?"""
    link.settimeout(within_s)
    try:
        return link.recv(1000) == b""
    except ConnectionResetError:
        return True
    except TimeoutError:
        return False


def is_answered(link):
    """Does an answer come whole?"""
    said = b""
    while not said.endswith(b"\r\n\r\nok"):
        part = link.recv(1000)
        if not part:
            return False
        said += part
    return said.startswith(b"HTTP/1.1 200")


def works(connect):
    with connect() as link:
        link.sendall(REQUEST)
        return is_answered(link)


@pytest.mark.parametrize("said", [b"\x16\x03\x01\0\xa5", b"GET / HTTP/1.1\r\nHost : x\r\n\r\n", b"hello\r\n\r\n"])
def test_what_is_no_http_is_answered_400_and_fills_no_log(said, caplog):
    with serving() as connect, connect() as link:
        link.sendall(said)
        assert everything(link).startswith(b"HTTP/1.1 400 ")
    assert not caplog.records


def test_a_head_that_is_too_long_is_answered_400():
    with serving() as connect, connect() as link:
        link.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + 100_000 * b"x")
        assert everything(link).startswith(b"HTTP/1.1 400 ")


def test_a_slow_answer_is_waited_for_though_the_time_of_an_idle_connection_is_over():
    with serving(keep_alive_s=0) as connect, connect() as link:
        link.sendall(LATE)
        assert is_answered(link)


def test_a_connection_without_another_request_is_closed():
    with serving(keep_alive_s=1) as connect, connect() as link:
        link.sendall(REQUEST)
        assert is_answered(link)
        assert not is_closed(link, 0.5)
        assert is_closed(link, 3)


def test_over_tls_it_answers_too():
    trusting = ssl.create_default_context(cafile=OURS.chain)
    with serving(OURS) as connect, trusting.wrap_socket(connect(), server_hostname="localhost") as link:
        link.sendall(REQUEST)
        assert is_answered(link)


def test_connections_beyond_the_most_are_answered_503_and_it_works_again_once_some_are_gone():
    with serving(max_connections=3) as connect:
        busy = [connect() for _ in range(2)]
        for link in busy:
            link.sendall(LATE)
        time.sleep(0.1)
        with connect() as third:
            third.sendall(REQUEST.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n"))
            assert everything(third).startswith(b"HTTP/1.1 503 ")
        for link in busy:
            assert is_answered(link)
            link.close()
        time.sleep(0.1)
        assert works(connect)


def test_without_such_a_bound_connections_that_say_nothing_keep_nobody_out():
    with serving() as connect:
        silent = [connect() for _ in range(300)]
        assert works(connect)
        for link in silent:
            link.close()


def test_fifty_pages_that_listen_and_fifty_that_poll_are_all_answered():
    with serving(max_connections=Limits().connections) as connect:
        listen = [connect() for _ in range(50)]
        for link in listen:
            link.sendall(LATE)
        poll = [connect() for _ in range(50)]
        for link in poll:
            link.sendall(REQUEST)
        assert all(is_answered(link) for link in [*listen, *poll])
        for link in [*listen, *poll]:
            link.close()


@pytest.mark.parametrize(
    "lines",
    [
        b"POST / HTTP/1.1\r\nContent-Length: 5\r\nTransfer-Encoding: chunked",
        b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\nContent-Length: 5",
        b"POST / HTTP/1.0\r\nTransfer-Encoding: chunked",
    ],
)
def test_a_request_that_says_in_two_ways_how_long_it_is_is_refused_and_what_follows_is_not_read(lines):
    with serving() as connect, connect() as link:
        link.sendall(lines + b"\r\nHost: localhost\r\n\r\n0\r\n\r\n" + REQUEST)
        head, _, body = everything(link).partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 400 ")
    assert b"application/problem+json" in head
    found = json.loads(body)
    assert found["title"] == "Two lengths"  # and no other answer after it
    assert found["remedy"] in found["detail"]


def test_a_body_in_pieces_is_taken():
    with serving() as connect, connect() as link:
        link.sendall(
            b"POST /body HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n2\r\nab\r\n0\r\n\r\n"
        )
        assert is_answered(link)


@pytest.mark.parametrize("certificate", [None, OURS])
def test_a_client_that_does_not_read_its_answer_is_dropped(certificate):
    trusting = ssl.create_default_context(cafile=OURS.chain)
    with serving(certificate, stalled_s=0.3) as connect:
        wire = connect()
        link = wire if certificate is None else trusting.wrap_socket(wire, server_hostname="localhost")
        link.sendall(REQUEST.replace(b"/ ", b"/big ", 1))
        time.sleep(2.0)
        size = 0
        # Without an error what the kernel still holds comes, and then the end.
        with suppress(ConnectionResetError, ssl.SSLEOFError):
            while part := link.recv(1 << 20):
                size += len(part)
        link.close()
    assert 0 < size < 20_000_000


def test_the_sender_of_a_body_that_is_not_read_gets_its_answer():
    with serving() as connect, connect() as link:
        link.sendall(b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3000000\r\n\r\n")
        link.sendall(b" " * 2_000_000)
        assert is_answered(link)

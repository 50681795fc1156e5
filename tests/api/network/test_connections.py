"""Connections that say nothing, too much or too slowly, on a server of its own with small limits."""

import asyncio
import json
import socket
import ssl
import threading
import time
from contextlib import contextmanager, suppress

import pytest

from platform_daemon.api.network.certificates import Certificate
from platform_daemon.api.network.connections import BoundedServer, bounded_config
from platform_daemon.api.network.limits import Limits
from tests.kit.command_line import wait_for
from tests.kit.data import DATA

OURS = Certificate(DATA / "tls/localhost.pem", DATA / "tls/localhost.key")
ASK = b"GET / HTTP/1.1\r\nHost: x\r\n\r\n"


async def answers(scope, receive, send):
    """Says ok, without reading a body; /big says 20 MB; /late after half a second; /body once the body is whole."""
    if scope["type"] != "http":
        return
    if scope["path"] == "/late":
        await asyncio.sleep(0.5)
    while scope["path"] == "/body":
        told = await receive()
        if told["type"] == "http.disconnect":
            return
        if not told.get("more_body"):
            break
    body = b"x" * 20_000_000 if scope["path"] == "/big" else b"ok"
    await send(
        {"type": "http.response.start", "status": 200, "headers": [(b"content-length", str(len(body)).encode())]}
    )
    await send({"type": "http.response.body", "body": body})


@contextmanager
def serving(certificate=None, **limits):
    listener = socket.create_server(("127.0.0.1", 0))
    server = BoundedServer(bounded_config(answers, Limits(**limits), certificate))
    thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    address = listener.getsockname()

    def connect(source="127.0.0.1"):
        return socket.create_connection(address, 5, (source, 0))

    connect.room = server.config.room
    try:
        yield connect
    finally:
        server.should_exit = True
        thread.join(10)
        assert not thread.is_alive()


@pytest.mark.parametrize("said", [b"\x16\x03\x01\0\xa5", b"GET / HTTP/1.1\r\nHost : x\r\n\r\n", b"hello\r\n\r\n"])
def test_what_is_no_http_is_answered_by_a_problem_and_fills_no_log(said, caplog):
    with serving() as connect, connect() as link:
        link.sendall(said)
        head, _, body = b"".join(iter(lambda: link.recv(1000), b"")).partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 400 ")
    assert b"application/problem+json" in head
    assert json.loads(body)["remedy"] in json.loads(body)["detail"]
    assert not caplog.records


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
        link.sendall(ASK)
        return is_answered(link)


@pytest.mark.parametrize("said", [b"", b"GET / HTTP/1.1\r\nHost:"], ids=["nothing", "half a head"])
def test_a_head_that_does_not_come_in_time_ends_the_connection(said):
    with serving(headers_s=0.3) as connect, connect() as link:
        link.sendall(said)
        assert not is_closed(link, 0.15)
        assert is_closed(link, 1)


def test_a_head_that_comes_drop_by_drop_gains_no_time_nor_does_a_second_request():
    with serving(headers_s=0.4) as connect, connect() as link:
        link.sendall(ASK)
        assert is_answered(link)
        began = time.monotonic()
        with suppress(OSError):
            for letter in 200 * b"x":
                link.sendall(bytes([letter]))
                time.sleep(0.02)
        assert 0.3 < time.monotonic() - began < 1.5


def test_a_slow_answer_is_waited_for():
    with serving(headers_s=0.2) as connect, connect() as link:
        link.sendall(ASK.replace(b"/ ", b"/late ", 1))
        assert is_answered(link)


def test_connections_that_say_nothing_make_room_for_those_that_ask():
    with serving(connections=5) as connect:
        silent = [connect() for _ in range(50)]
        assert works(connect)
        assert works(connect)
        time.sleep(0.05)
        assert sum(not is_closed(link, 0.01) for link in silent) <= 5
        for link in silent:
            link.close()


def test_those_that_do_not_even_begin_with_tls_make_room_too():
    trusting = ssl.create_default_context(cafile=OURS.chain)
    with serving(OURS, handshakes=5) as connect:
        with trusting.wrap_socket(connect(), server_hostname="localhost") as known:
            silent = [connect() for _ in range(50)]
            assert sum(not is_closed(link, 0.05) for link in silent) <= 5
            with trusting.wrap_socket(connect(), server_hostname="localhost") as another:
                another.sendall(ASK)
                assert is_answered(another)
            known.sendall(ASK)
            assert is_answered(known)
        for link in silent:
            link.close()


def test_who_connects_again_and_again_keeps_nobody_else_from_being_let_in():
    trusting = ssl.create_default_context(cafile=OURS.chain)
    with serving(OURS, handshakes=5) as connect, connect("127.0.0.2") as slow:
        flood = [connect() for _ in range(50)]
        assert not is_closed(slow, 0.05)
        slow.settimeout(5)
        with trusting.wrap_socket(slow, server_hostname="localhost") as link:
            link.sendall(ASK)
            assert is_answered(link)
        for link in flood:
            link.close()


def test_one_that_has_asked_before_stays_longer_than_one_that_never_did():
    with serving(connections=3) as connect, connect() as known:
        known.sendall(ASK)
        assert is_answered(known)
        silent = [connect() for _ in range(10)]
        assert works(connect)
        known.sendall(ASK)
        assert is_answered(known)
        for link in silent:
            link.close()


BODY = b"POST /%s HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\n\r\nab"


def test_who_holds_bodies_back_has_a_share_and_the_oldest_of_them_make_room():
    with serving(connections=4, connections_per_client=3, headers_s=5) as connect:
        slow = [connect() for _ in range(10)]
        for link in slow:
            link.sendall(BODY % b"body")
            time.sleep(0.02)
        assert sum(not is_closed(link, 0.02) for link in slow) <= 3
        assert works(connect)
        slow[-1].sendall(b"cde")
        assert is_answered(slow[-1])
        for link in slow:
            link.close()


def test_who_has_all_of_his_share_answered_is_told_so_and_another_client_is_let_in():
    with serving(connections=4, connections_per_client=2) as connect:
        busy = [connect() for _ in range(2)]
        for link in busy:
            link.sendall(ASK.replace(b"/ ", b"/late ", 1))
        time.sleep(0.1)
        with connect() as third, third.makefile("rb") as stream:
            head, _, body = stream.read().partition(b"\r\n\r\n")
            assert head.startswith(b"HTTP/1.1 503")
            assert "one client" in json.loads(body)["title"]
        with connect("127.0.0.2") as other:
            other.sendall(ASK)
            assert is_answered(other)
        for link in busy:
            assert is_answered(link)
            link.close()
        assert works(connect)


def test_who_is_turned_away_and_does_not_go_is_cut_off_once_too_many_stay():
    """The end of TLS has two sides: asyncio waits for the other one for half a minute."""
    trusting = ssl.create_default_context(cafile=OURS.chain)
    with serving(OURS, connections=2, handshakes=3) as connect:
        busy = [trusting.wrap_socket(connect(), server_hostname="localhost") for _ in range(2)]
        for link in busy:
            link.sendall(100 * ASK.replace(b"/ ", b"/late ", 1))
        time.sleep(0.1)
        away = [trusting.wrap_socket(connect(), server_hostname="localhost") for _ in range(12)]
        for link in away:
            assert b"".join(iter(lambda link=link: link.recv(1000), b"")).startswith(b"HTTP/1.1 503")
        wires = [link.detach() for link in away]
        there = [socket.socket(fileno=number) for number in wires]
        assert sum(not is_closed(wire, 0.05) for wire in there) <= 3
        for each in (*busy, *there):
            each.close()


def test_the_own_pages_fit_into_the_share_of_one_address():
    with serving() as connect:
        listen = [connect() for _ in range(50)]
        for link in listen:
            link.sendall(ASK.replace(b"/ ", b"/late ", 1))
        poll = [connect() for _ in range(50)]
        for link in poll:
            link.sendall(ASK)
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
        link.sendall(lines + b"\r\nHost: x\r\n\r\n0\r\n\r\n" + ASK)
        head, _, body = b"".join(iter(lambda: link.recv(1000), b"")).partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 400 ")
    assert json.loads(body)["title"] == "Two lengths"  # and no other answer after it


def test_a_body_in_pieces_is_taken():
    with serving() as connect, connect() as link:
        link.sendall(b"POST /body HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n2\r\nab\r\n0\r\n\r\n")
        assert is_answered(link)


def test_where_all_are_being_answered_another_one_is_told_to_come_again():
    with serving(connections=2) as connect:
        busy = [connect() for _ in range(2)]
        for link in busy:
            link.sendall(ASK.replace(b"/ ", b"/late ", 1))
        time.sleep(0.1)
        with connect() as third, third.makefile("rb") as stream:
            head, _, body = stream.read().partition(b"\r\n\r\n")
            assert head.startswith(b"HTTP/1.1 503")
            assert b"retry-after: 1" in head
            assert json.loads(body)["status"] == 503
        for link in busy:
            assert is_answered(link)
            link.close()
        assert works(connect)


def test_who_does_not_read_the_answer_is_dropped():
    with serving(stalled_s=0.3) as connect, connect() as link:
        link.sendall(ASK.replace(b"/ ", b"/big ", 1))
        time.sleep(0.8)
        size = 0
        with suppress(ConnectionResetError):  # else what the kernel still holds comes, and then the end
            while part := link.recv(1 << 20):
                size += len(part)
        assert 0 < size < 20_000_000


@pytest.mark.parametrize("certificate", [None, OURS])
def test_of_an_answer_that_is_not_read_as_much_waits_over_tls_as_without(certificate):
    trusting = ssl.create_default_context(cafile=OURS.chain)
    with serving(certificate) as connect, connect() as link:
        if certificate is not None:
            link = trusting.wrap_socket(link, server_hostname="localhost")
        link.sendall(ASK)
        assert is_answered(link)
        wait_for(lambda: connect.room.answered)
        (known,) = connect.room.answered
        assert known.transport.get_write_buffer_limits()[1] == 64 * 1024
        link.close()


def test_a_body_that_nobody_reads_does_not_keep_its_sender_from_the_answer_and_ends():
    with serving(headers_s=0.5) as connect, connect() as link:
        link.sendall(b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 3000000\r\n\r\n")
        link.sendall(b" " * 2_000_000)
        assert is_answered(link)
        assert is_closed(link, 2)
    with serving() as connect, connect() as link:
        link.sendall(b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 100000000\r\n\r\n")
        sent = 0
        with suppress(OSError):
            for _ in range(100):
                link.sendall(b" " * 1_000_000)
                sent += 1
        assert sent < 60

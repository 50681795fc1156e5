"""One port."""

import fcntl
import resource
import socket

import pytest

from drivers.errors import DeviceNotFound
from drivers.red_pitaya.ports import connect, peek
from tests.kit.scripted_daq_server import listener

HIGH = 1100  # select takes none above 1023


@pytest.fixture
def many_files():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 2 * HIGH)), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_a_socket_of_a_process_with_many_files_is_not_taken_for_closed(many_files):
    ours, theirs = socket.socketpair()
    with theirs, socket.socket(fileno=fcntl.fcntl(ours, fcntl.F_DUPFD, HIGH)) as high:
        ours.close()
        assert peek(high, 0.0) is None
        theirs.sendall(b"x")
        assert peek(high, 1.0) == b"x"
        theirs.shutdown(socket.SHUT_RDWR)
        high.recv(1)
        assert peek(high, 1.0) == b""
    assert peek(high, 0.0) == b""


@pytest.fixture
def names(monkeypatch):
    """What names stand for, which may change, and which of them were asked for."""
    known, asked, ask = {}, [], socket.getaddrinfo

    def answer(host, *rest, **more):
        if host in known:
            asked.append(host)
            host = known[host]
        return ask(host, *rest, **more)

    monkeypatch.setattr(socket, "getaddrinfo", answer)
    return known, asked


def test_a_name_is_asked_for_once_and_again_when_its_address_has_failed(names):
    known, asked = names
    known["card.test"] = "127.0.0.1"
    with listener() as first:
        first.listen(8)
        port = first.getsockname()[1]
        for _ in range(2):
            connect("card.test", port).close()
        known["card.test"] = "no-such-card.invalid"  # no name server answers any more
        connect("card.test", port).close()
        assert asked == ["card.test"]
    with pytest.raises(DeviceNotFound):
        connect("card.test", port)
    known["card.test"] = "127.0.0.1"
    with listener() as other:
        connect("card.test", other.getsockname()[1]).close()
    assert asked == 2 * ["card.test"]

"""One port."""

import fcntl
import resource
import socket

import pytest

from drivers.red_pitaya.ports import said_within

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
        assert said_within(high, 0.0) is None
        theirs.sendall(b"x")
        assert said_within(high, 1.0) == b"x"
        theirs.shutdown(socket.SHUT_RDWR)
        high.recv(1)
        assert said_within(high, 1.0) == b""
    assert said_within(high, 0.0) == b""

"""Listeners to events that never read."""

import contextlib
import socket
import threading

import pytest
import uvicorn

from platform_daemon.core.schemas.access import Role
from platform_daemon.core.schemas.events import DeviceEvent
from platform_daemon.core.state.event_journal import EventJournal
from platform_daemon.core.web import event_tail
from platform_daemon.core.web.network import http_server
from platform_daemon.core.web.network.limits import Limits
from platform_daemon.core.web.routes import events as event_routes
from tests.kit.command_line import wait_for

MANY = 20


@pytest.fixture
def stack():
    with contextlib.ExitStack() as made:
        yield made


@pytest.mark.long
def test_those_that_never_read_hold_little_memory_and_are_dropped(secured, monkeypatch, stack):
    monkeypatch.setattr(event_tail, "MOST_LISTENERS", MANY)
    app, events = secured.client.app, secured.client.app.state.context.events
    journal = EventJournal(secured.folder / "events.db")
    for k in range(5000):
        journal.tell(DeviceEvent(device="nobody", error=f"{k} {'x' * 2000}"))
    journal.close()
    listener = socket.create_server(("127.0.0.1", 0))
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 16_384)  # what the kernel holds is not ours
    servers = []
    create = uvicorn.Server
    monkeypatch.setattr(http_server.uvicorn, "Server", lambda config: servers.append(create(config)) or servers[0])
    stack.enter_context(http_server.running_server(app, listener, limits=Limits(stalled_s=10.0)))
    (server,) = servers
    token = secured.headers[Role.VIEWER]["Authorization"].encode()
    links = [socket.socket() for _ in range(MANY)]
    for link in links:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        link.connect(listener.getsockname())
        link.sendall(b"GET /events?after=0 HTTP/1.1\r\nHost: localhost\r\nAuthorization: " + token + b"\r\n\r\n")
    wait_for(lambda: events.full)
    held = [0]

    def waits():
        held.extend(each.transport.get_write_buffer_size() for each in list(server.server_state.connections))
        return len(held) > 20 * MANY

    wait_for(lambda: waits() and max(held) > 0)
    assert max(held) < 200_000  # of ten million bytes that there are for each
    wait_for(lambda: not server.server_state.connections, 60)
    wait_for(lambda: not events.full, 20)
    for link in links:
        link.close()


def test_one_whose_token_is_revoked_hears_nothing_more(secured, monkeypatch):
    monkeypatch.setattr(event_routes, "_RECHECK_S", 0.0)
    monkeypatch.setattr(event_tail, "MOST_LISTENERS", 1)
    headers = {"Authorization": f"Bearer {secured.tokens.add('guest', Role.VIEWER)}"}
    heard = []
    listens = threading.Thread(
        target=lambda: heard.append(secured.client.get("/events", headers=headers).text), daemon=True
    )
    tail = secured.client.app.state.context.events
    listens.start()
    wait_for(lambda: tail.full)
    secured.tokens.revoke("guest")
    journal = EventJournal(secured.folder / "events.db")
    journal.tell(DeviceEvent(device="nobody", error="not for everybody"))
    journal.close()
    listens.join(10)
    assert (listens.is_alive(), "not for everybody" in "".join(heard)) == (False, False)


def test_one_whose_token_is_revoked_gives_its_place_back_though_nothing_happens(secured, monkeypatch):
    monkeypatch.setattr(event_tail, "MOST_LISTENERS", 1)
    monkeypatch.setattr(event_tail, "_RECHECK_S", 0.1)
    headers = {"Authorization": f"Bearer {secured.tokens.add('quiet', Role.VIEWER)}"}
    listens = threading.Thread(target=lambda: secured.client.get("/events", headers=headers), daemon=True)
    tail = secured.client.app.state.context.events
    listens.start()
    wait_for(lambda: tail.full)
    secured.tokens.revoke("quiet")
    wait_for(lambda: not tail.full, 5)
    listens.join(10)
    assert not listens.is_alive()

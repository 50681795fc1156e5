"""The configuration of nginx in `docs/howto/rest-and-network.md`: what passes, and what strangers cannot do."""

from __future__ import annotations

import re
import socket
import ssl
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest

from platform_daemon.core.schemas.access import Role
from platform_daemon.core.state.tokens import tokens_in
from tests.kit.command_line import wait_for
from tests.kit.data import DATA, ROOT
from tests.kit.served import served

pytestmark = pytest.mark.long
NAME = "localhost"
FRAME = """
user root;
worker_processes 1;
pid {folder}/pid;
events {{ worker_connections 4096; }}
http {{
    access_log {folder}/access.log;
    client_body_temp_path {folder}/body;
    proxy_temp_path {folder}/proxy;
    fastcgi_temp_path {folder}/fastcgi;
    uwsgi_temp_path {folder}/uwsgi;
    scgi_temp_path {folder}/scgi;
    {site}
}}
"""


def site(port, main, stop):
    """The configuration of the page, with the ports, names and files of this test in the place of its examples."""
    page = (ROOT / "docs/howto/rest-and-network.md").read_text()
    text = re.search(r"```nginx\n(.*?)```", page, re.DOTALL)[1]
    for example, ours in (
        ("listen 443 ssl", f"listen 127.0.0.1:{port} ssl"),
        ("lab.example.org", NAME),
        ("/etc/ssl/lab.pem", DATA / "tls/localhost.pem"),
        ("/etc/ssl/lab.key", DATA / "tls/localhost.key"),
        ("http://127.0.0.1:8212", main),
        ("http://127.0.0.1:8213", stop),
    ):
        assert example in text
        text = text.replace(example, str(ours))
    return text


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


@contextmanager
def nginx(folder, main, stop):
    """nginx with that configuration; its port."""
    folder.mkdir()
    port = free_port()
    (folder / "nginx.conf").write_text(FRAME.format(folder=folder, site=site(port, main, stop)))
    process = subprocess.Popen([ROOT / "tests/kit/nginx.sh", folder])
    try:
        wait_for(lambda: process.poll() is not None or _listens(port), 300)
        assert process.poll() is None, (folder / "error.log").read_text()
        yield port
    finally:
        process.terminate()
        process.wait(30)


def _listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture(scope="module")
def proxied(tmp_path_factory):
    """A client with a token of an operator, through the proxy; the client has the port of the proxy."""
    folder: Path = tmp_path_factory.mktemp("proxied")
    token = tokens_in(folder / "data").add("ann", Role.OPERATOR)
    trusting = ssl.create_default_context(cafile=str(DATA / "tls/localhost.pem"))
    with (
        served(folder / "data", "--allowed-host", NAME) as daemon,
        nginx(folder / "nginx", daemon.address, daemon.stop.removesuffix("/stop")) as port,
        httpx2.Client(
            base_url=f"https://{NAME}:{port}",
            verify=trusting,
            headers={"authorization": f"Bearer {token}"},
            timeout=60,
        ) as client,
    ):
        client.port, client.trusting = port, trusting
        wait_for(lambda: client.get("/ready").status_code == 200)
        yield client


BELOW = """
server {
    listen 127.0.0.1:%d ssl;
    ssl_certificate %s;
    ssl_certificate_key %s;
    location /mmr/ { proxy_set_header Host $http_host; proxy_http_version 1.1; proxy_pass %s/; }
}
"""


def test_below_a_path_links_schema_and_page_lead_back(tmp_path, monkeypatch):
    with served(tmp_path / "data", "--root-path", "/mmr", "--allowed-host", NAME) as daemon:
        tls = (DATA / "tls/localhost.pem", DATA / "tls/localhost.key")
        monkeypatch.setattr(sys.modules[__name__], "site", lambda port, main, stop: BELOW % (port, *tls, main))
        trusting = ssl.create_default_context(cafile=str(tls[0]))
        with (
            nginx(tmp_path / "nginx", daemon.address, daemon.stop) as port,
            httpx2.Client(base_url=f"https://{NAME}:{port}", verify=trusting, timeout=60) as client,
        ):
            wait_for(lambda: client.get("/mmr/ready").status_code == 200)
            assert client.get("/mmr/openapi.json").json()["servers"] == [{"url": "/mmr"}]
            started = client.post("/mmr/acquisitions", json={"resonator": "jewel", "shots": 1})
            at = started.headers["location"]
            assert at.startswith("/mmr/acquisitions/")
            wait_for(lambda: client.get(at).json()["state"] == "done")
            page = client.get("/mmr/", headers={"accept": "text/html"}, follow_redirects=True)
            assert page.url.path.startswith("/mmr/")
            named = re.findall(r'(?:src|href)="([^"]+)"', page.text)
            assert named
            for each in named:
                assert client.get(page.url.join(each)).status_code == 200, each


def test_requests_pass_and_tokens_are_demanded(proxied):
    assert proxied.get("/platform").status_code == 200
    assert proxied.get("/platform", headers={"authorization": ""}).status_code == 401
    assert proxied.post("/stop").status_code == 200
    job = proxied.post("/acquisitions", json={"resonator": "jewel", "shots": 1})
    assert job.status_code == 202
    assert proxied.get(job.headers["location"]).status_code == 200
    wait_for(lambda: proxied.get(job.headers["location"]).json()["state"] == "done")


def test_a_page_of_this_server_may_change_things_and_one_of_another_server_may_not(proxied):
    own = {"origin": f"https://{NAME}:{proxied.port}"}
    assert proxied.post("/stop", json={}, headers=own).status_code == 200
    assert proxied.post("/stop", json={}, headers={"origin": "https://elsewhere.example"}).status_code == 403


def test_events_come_at_once(proxied):
    with proxied.stream("GET", "/events") as stream:
        lines = stream.iter_lines()
        began = time.monotonic()
        proxied.post("/acquisitions", json={"resonator": "jewel", "shots": 1})
        assert any("job" in line for line in lines)
        assert time.monotonic() - began < 10  # a buffer of some kB would not fill for long


def test_two_lengths_of_a_body_do_not_reach_the_daemon(proxied):
    with connected(proxied) as link:
        lines = (
            b"POST /acquisitions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n"
        )
        link.sendall(lines + b"0\r\n\r\n")
        assert link.recv(100).startswith(b"HTTP/1.1 400 ")


def test_a_body_that_is_too_large_is_refused(proxied):
    assert proxied.post("/predict", content=b" " * 2_000_000).status_code == 413


def test_one_address_has_no_more_than_its_connections_and_stop_is_answered_meanwhile(proxied):
    streams = [connected(proxied) for _ in range(40)]
    token = proxied.headers["authorization"].encode()
    try:
        for link in streams:
            link.sendall(b"GET /events HTTP/1.1\r\nHost: localhost\r\nAuthorization: " + token + b"\r\n\r\n")
        heads = [link.recv(15) for link in streams]
        assert heads.count(b"HTTP/1.1 200 OK") == 20
        assert sum(head.startswith(b"HTTP/1.1 429") for head in heads) == 20
        assert proxied.get("/platform").status_code == 429
        assert proxied.post("/stop").status_code == 200
    finally:
        for link in streams:
            link.close()
    wait_for(lambda: proxied.get("/platform").status_code == 200)


def test_connections_that_say_nothing_keep_nobody_out_and_are_dropped(proxied):
    silent = [socket.create_connection(("127.0.0.1", proxied.port), 5) for _ in range(1000)]
    try:
        assert proxied.get("/platform").status_code == 200
        assert proxied.post("/stop").status_code == 200
        silent[0].settimeout(60)
        assert silent[0].recv(1) == b""
    finally:
        for link in silent:
            link.close()


def test_a_client_that_asks_too_often_is_refused_and_stop_is_not(proxied):
    request, links = b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n", [connected(proxied) for _ in range(18)]
    began = time.monotonic()
    try:
        for link in links:
            link.sendall(50 * request)
        assert proxied.post("/stop").status_code == 200
        answers = []
        for link in links:
            with link.makefile("rb") as stream:
                answers += [_status(stream) for _ in range(50)]
        seconds = time.monotonic() - began
    finally:
        for link in links:
            link.close()
    assert set(answers) <= {200, 429}
    assert 0 < answers.count(200) <= 101 + 50 * seconds
    assert {proxied.post("/stop").status_code for _ in range(20)} == {200}


def _status(stream):
    """Of one answer, which is read to its end."""
    status, length = int(stream.readline().split()[1]), 0
    while (line := stream.readline().strip()) != b"":
        name, _, value = line.partition(b":")
        length = int(value) if name.lower() == b"content-length" else length
    stream.read(length)
    return status


def connected(proxied):
    """A connection through TLS."""
    link = socket.create_connection(("127.0.0.1", proxied.port), 10)
    return proxied.trusting.wrap_socket(link, server_hostname=NAME)

"""Below a path, and behind a proxy that speaks TLS: links of the server lead back to it."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from fastapi.testclient import TestClient

from platform_daemon.core.web.server import create_api
from tests.kit.command_line import assert_one_line_error, here


def client(root_path=""):
    app = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None)), root_path=root_path)
    return TestClient(app, base_url="http://127.0.0.1", follow_redirects=False)


def test_a_redirect_names_neither_scheme_nor_host():
    """Case 11: behind a proxy that speaks TLS."""
    for headers in ({}, {"X-Forwarded-Proto": "https"}):
        answer = client().get("/recordings/", headers=headers)
        assert (answer.status_code, answer.headers["location"]) == (307, "/recordings")


@pytest.mark.parametrize("path", ["/recordings/", "/mmr/recordings/"])  # of proxies that cut the path off or leave it
def test_a_redirect_stays_below_the_root_path(path):
    assert client("/mmr").get(path).headers["location"] == "/mmr/recordings"


def test_the_documentation_finds_its_schema_below_the_root_path():
    below = client("/mmr")
    assert "url: '/mmr/openapi.json'" in below.get("/docs").text
    assert below.get("/openapi.json").json()["servers"] == [{"url": "/mmr"}]
    assert "servers" not in client().get("/openapi.json").json()


@pytest.mark.parametrize("path", ["mmr", "/mmr/", "/", "/m r", "//evil"])
def test_what_is_no_path_is_refused(path):
    assert_one_line_error(here("serve", "--root-path", path, "--port", "0"), 2, "--root-path", "/mmr")

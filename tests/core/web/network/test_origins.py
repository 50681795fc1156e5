"""Names of the host, pages of other servers, and bodies that a form of a browser could send."""

import pytest

from platform_daemon.core.schemas.access import Role
from tests.kit.rest import problem

FORMS = ("application/x-www-form-urlencoded", "multipart/form-data; boundary=x", "text/plain")
CHANGES = ("/stop", "/devices/power_amplifier/reset", "/procedures/x/pause", "/calibrations/x/continue")


@pytest.fixture
def ask(secured):
    def ask(method, path, headers=None, **request):
        return secured.client.request(method, path, headers=secured.headers[Role.ADMIN] | (headers or {}), **request)

    return ask


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1.evil.example",
        "evil.example:8212",
        "",
        "[::1",
        "localhost@x",
        "x@localhost",
        "127.0.0.1/x",
        "127.0.0.1?x",
        "localhost..",
    ],
)
@pytest.mark.parametrize(
    ("method", "path"), [("GET", "/health"), ("POST", "/stop"), ("GET", "/docs"), ("GET", "/nothing")]
)
def test_a_request_to_another_host_is_refused_whatever_it_asks(ask, host, method, path):
    answer = ask(method, path, {"Host": host})
    assert "--allowed-host" in problem(answer, 421)["remedy"]


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "127.0.0.1:8212", "localhost:1", "LOCALHOST", "[::1]:8212", "localhost."]
)
def test_loopback_by_any_of_its_names_is_this_server(ask, host):
    assert ask("GET", "/health", {"Host": host}).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:9999"},
        {"Origin": "http://["},
        {"Origin": ""},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
@pytest.mark.parametrize("path", [*CHANGES, "/acquisitions", "/predict"])
def test_pages_of_other_servers_change_nothing(ask, headers, path):
    assert "Origin" in problem(ask("POST", path, headers, json={}), 403)["detail"]
    assert ask("GET", "/platform", headers).status_code == 200


def test_a_page_of_this_server_may(ask):
    own = {"Origin": "http://127.0.0.1", "Sec-Fetch-Site": "same-origin"}
    assert ask("POST", "/stop", own).status_code == 200


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("path", [*CHANGES, "/acquisitions"])
def test_what_a_form_can_send_changes_nothing(ask, path, form):
    assert "Content-Type" in problem(ask("POST", path, {"Content-Type": form}, content=b"{}"), 415)["where"]
    assert ask("POST", path, {"Content-Type": form}).status_code == 415


@pytest.mark.parametrize("path", ["/acquisitions/x", "/fits/x", "/calibrations/x"])
def test_a_delete_may_say_nothing_of_a_body_that_it_has_not(ask, path):
    assert ask("DELETE", path).status_code == 404
    for headers, body in (({"Content-Type": "text/plain"}, b""), ({}, b"{}")):
        assert "Content-Type" in problem(ask("DELETE", path, headers, content=body), 415)["where"]


@pytest.mark.parametrize("path", CHANGES[1:])
def test_a_post_without_values_says_that_it_is_json_too(ask, path):
    problem(ask("POST", path), 415)
    assert ask("POST", path, json={}).status_code in (200, 404)
    assert ask("POST", path, {"Content-Type": "application/json"}).status_code in (200, 404)
    assert ask("POST", path, json={"x": 1}).status_code == 422


def test_stop_alone_needs_no_content_type_but_a_body_of_it_does(ask):
    assert ask("POST", "/stop").status_code == 200
    assert ask("POST", "/stop", json={}).status_code == 200
    assert ask("POST", "/stop", content=b"{}").status_code == 415

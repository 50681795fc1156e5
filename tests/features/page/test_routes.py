"""The files of the page: what a browser is sent, and what it is told."""

import re
from pathlib import Path

import pytest

from platform_daemon.core.schemas.parameters import PARAMETERS
from platform_daemon.features.page import files
from tests.kit.rest import problem

STATIC = Path(files.__file__).parent / "static"


def test_a_browser_is_led_to_the_page_and_a_program_is_not(client):
    browser = client.get("/", headers={"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}, follow_redirects=False)
    assert (browser.status_code, browser.headers["location"]) == (303, "page/")
    program = client.get("/")
    assert program.json()["links"]["page"] == "/page"
    assert program.headers["vary"] == browser.headers["vary"] == "Accept"


def test_the_page_takes_nothing_from_elsewhere(client):
    answer = client.get("/page/")
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    policy = answer.headers["content-security-policy"]
    assert policy.startswith("default-src 'self'; connect-src 'self';")
    for path in STATIC.rglob("*.*"):
        found = re.findall(r"(?:https?:)?//[a-z][\w.]*\.[a-z]+", path.read_text())
        assert set(found) <= {"http://www.w3.org"}, path  # the name of SVG, which nobody fetches


def test_a_file_that_has_not_changed_is_not_sent_again(client):
    first = client.get("/page/main.js")
    assert first.headers["content-type"].startswith("text/javascript")
    again = client.get("/page/main.js", headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    other = client.get("/page/main.js", headers={"If-None-Match": '"other"'})
    assert other.content == first.content


def test_only_files_of_the_page_are_there(client):
    for path in ("nothing.js", "..%2froutes.py", "%2e%2e/routes.py", "../files.py", "views/../../routes.py"):
        assert client.get(f"/page/{path}").status_code == 404, path
    assert "make install" in problem(client.get("/page/vendor/other.js"), 404)["remedy"]


def test_a_library_that_is_not_installed_is_named_with_its_remedy(client, monkeypatch):
    def missing(path, **_):
        raise FileNotFoundError(path)

    monkeypatch.setattr(Path, "stat", missing)
    assert "make install" in problem(client.get("/page/vendor/uPlot.iife.min.js"), 404)["remedy"]


def test_symbols_and_units_come_from_the_one_table(client):
    found = client.get("/page/parameters.json").json()
    assert list(found) == list(PARAMETERS)
    assert found["m_r_am2"]["display_unit"] == "mAm²"


@pytest.mark.parametrize(("host", "allowed"), [("localhost:8212", " http://localhost:8213"), ("[::1]:8212", "")])
def test_the_page_may_reach_the_stop_port_of_its_own_host(client, monkeypatch, host, allowed):
    network = client.app.state.network
    for name, value in {"port": 8212, "stop_port": 8213}.items():
        monkeypatch.setitem(network.__dict__, name, value)
    answer = client.get("/page/", headers={"Host": host})
    assert f"connect-src 'self'{allowed};" in answer.headers["content-security-policy"]
    assert 'data-port="8212" data-stop-port="8213"' in answer.text

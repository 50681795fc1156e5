"""A daemon and a real Chromium; what the page must never do is watched in every test."""

from __future__ import annotations

import shutil
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import sync_playwright

from tests.kit.browser import visit
from tests.kit.command_line import wait_for
from tests.kit.served import ready


@pytest.fixture(scope="package")
def chromium():
    path = shutil.which("chromium")
    assert path is not None, "install Debian's chromium: `make test-page` does"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(scope="package")
def shared_daemon(tmp_path_factory):
    with ready(tmp_path_factory.mktemp("page") / "data") as running:
        yield running


@pytest.fixture
def daemon(shared_daemon):
    yield shared_daemon
    wait_for(lambda: shared_daemon.stop_all().status_code == 200)
    wait_for(lambda: shared_daemon.get("/platform").json()["running"] is None)


@pytest.fixture
def browse(chromium, daemon):
    """Opens a browser of its own on the daemon; afterwards there were no errors and no requests to elsewhere."""
    opened = []
    yield lambda **options: opened.append(visit(chromium, daemon.address, **options)) or opened[-1]
    for each in opened:
        each.context.close()
        assert each.errors == []
        assert {urlsplit(url).hostname for url in each.requests} <= {"127.0.0.1", None}

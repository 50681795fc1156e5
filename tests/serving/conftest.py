"""One daemon for all tests of this folder that neither end it nor ask for options of their own: a start costs six
seconds of a processor."""

from __future__ import annotations

import pytest

from tests.kit.command_line import wait_for
from tests.kit.served import served


@pytest.fixture(scope="package")  # not of the session: an idle daemon takes 2 % of a processor
def shared_daemon(tmp_path_factory):
    with served(tmp_path_factory.mktemp("served") / "data") as running:
        yield running


@pytest.fixture
def daemon(shared_daemon):
    """Idle and without schedules, however the test before ended; what was measured stays."""
    yield shared_daemon
    wait_for(lambda: shared_daemon.stop_all().status_code == 200)
    for schedule in shared_daemon.get("/schedules").json():
        shared_daemon.delete(f"/schedules/{schedule['identifier']}")
    wait_for(lambda: shared_daemon.get("/platform").json()["running"] is None)

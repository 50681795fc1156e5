"""The schema of the API, apart from what it says."""

import threading

from fastapi import FastAPI

from platform_daemon.api import make_schema_soon
from tests.kit.command_line import wait_for


def test_it_is_made_beside_those_who_ask_for_other_things():
    app, made_by = FastAPI(), []
    original = app.openapi

    def slow():
        made_by.append(threading.current_thread().name)
        return original()

    app.openapi = slow
    make_schema_soon(app)
    wait_for(lambda: app.openapi_schema is not None)
    assert made_by == ["schema"]

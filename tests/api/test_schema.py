"""The schema of the API, apart from what it says."""

import asyncio
import re
import threading
from types import SimpleNamespace

import jsonschema_rs
import pytest
from fastapi.testclient import TestClient

from platform_daemon.api import create_api


@pytest.fixture
def app(monkeypatch):
    """One whose schema may not be made where all requests are answered."""
    app = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None)))
    app.state.made_by = []

    def made():
        with pytest.raises(RuntimeError):
            asyncio.get_running_loop()
        app.state.made_by.append(threading.current_thread())
        return {"openapi": "3.1.0"}

    monkeypatch.setattr(app, "openapi", made)
    return app


def test_it_is_made_beside_those_who_ask_for_other_things(app):
    client = TestClient(app, base_url="http://127.0.0.1")
    assert client.get("/openapi.json").json() == {"openapi": "3.1.0"}
    assert client.get("/docs").status_code == 200
    assert len(app.state.made_by) == 1


def test_nobody_needs_it_to_be_told_which_methods_there_are(app):
    client = TestClient(app, base_url="http://127.0.0.1")
    for path, allowed in (
        ("/stop", "POST"),
        ("/acquisitions/x", "DELETE, GET, HEAD, PUT"),
        ("/fits", "GET, HEAD, POST"),
    ):
        assert client.request("PATCH", path).headers["allow"] == allowed
    assert not app.state.made_by


def test_allow_names_what_works_also_where_a_name_may_hold_slashes():
    app = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None)))
    client = TestClient(app, base_url="http://127.0.0.1")
    for path, item in app.openapi()["paths"].items():
        there = re.sub(r"\{\w+\}", "x", path)
        allowed = client.patch(there).headers["allow"].split(", ")
        assert {method.upper() for method in item} <= set(allowed), path
        # Of /acquisitions/dry-run no job has the id: what would be routed to /acquisitions/{identifier} never works.
        for method in {"POST", "PUT", "DELETE"} - set(allowed) if "{" in path else ():
            assert client.request(method, there).status_code == 405, (method, path)
    assert client.patch("/specimens/X/baseline").headers["allow"] == "POST"
    assert client.patch("/events").headers["allow"] == "GET"


def test_every_example_of_a_component_is_one():
    components = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None))).openapi()["components"]
    checked = 0
    for name, component in components["schemas"].items():
        asked = {"$ref": f"#/components/schemas/{name}", "components": components}
        valid = jsonschema_rs.Draft202012Validator(asked)
        for example in component.get("examples", []):
            assert [str(error) for error in valid.iter_errors(example)] == [], name
            checked += 1
    assert checked > 80


def test_events_are_described_in_words_that_the_version_of_the_schema_has():
    schema = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None))).openapi()
    assert schema["openapi"] == "3.1.0"
    stream = schema["paths"]["/events"]["get"]["responses"]["200"]["content"]["text/event-stream"]
    assert set(stream) == {"schema"}
    assert "#/components/schemas/Event" in stream["schema"]["description"]
    assert "what" in schema["components"]["schemas"]["Event"]["properties"]

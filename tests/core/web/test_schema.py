"""The schema of the API, apart from what it says."""

import asyncio
import json
import re
import threading
from types import SimpleNamespace

import jsonschema_rs
import pytest
from fastapi.testclient import TestClient

from platform_daemon.core.web import openapi
from platform_daemon.core.web.openapi_file import OPENAPI_FILE
from platform_daemon.core.web.server import create_api
from tests.kit import openapi_file


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
    monkeypatch.setattr(openapi, "__version__", "another than the file's")
    return app


def test_it_is_made_beside_those_who_ask_for_other_things(app):
    client = TestClient(app, base_url="http://127.0.0.1")
    assert client.get("/openapi.json").json() == {"openapi": "3.1.0"}
    assert client.get("/docs").status_code == 200
    assert len(app.state.made_by) == 1


def test_the_file_in_the_package_is_what_the_code_says():
    written = openapi_file.text_of(openapi_file.made())
    assert OPENAPI_FILE.read_text() == written, "run `python -m tests.kit.openapi_file`"
    assert json.loads(written) == openapi_file.made()


def test_the_file_is_the_answer_and_nothing_is_made(monkeypatch):
    app = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None)))
    monkeypatch.setattr(app, "openapi", None)
    answer = TestClient(app, base_url="http://127.0.0.1").get("/openapi.json")
    assert answer.content == OPENAPI_FILE.read_bytes()
    assert answer.headers["content-type"] == "application/json"


def test_it_is_made_where_there_are_other_operations_than_those_of_the_file():
    app = create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None)))
    packaged = OPENAPI_FILE.read_bytes()
    assert openapi.describes(packaged, app)
    app.get("/another")(lambda: None)
    assert not openapi.describes(packaged, app)


def test_nobody_needs_it_to_be_told_which_methods_there_are(app):
    client = TestClient(app, base_url="http://127.0.0.1")
    for path, allowed in (
        ("/stop", "POST"),
        ("/acquisitions/x", "DELETE, GET, HEAD, PUT"),
        ("/fits", "GET, HEAD, POST"),
    ):
        assert client.request("PATCH", path).headers["allow"] == allowed
    assert not app.state.made_by


@pytest.mark.long
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
    components = openapi_file.made()["components"]
    checked = 0
    for name, component in components["schemas"].items():
        asked = {"$ref": f"#/components/schemas/{name}", "components": components}
        valid = jsonschema_rs.Draft202012Validator(asked)
        for example in component.get("examples", []):
            assert [str(error) for error in valid.iter_errors(example)] == [], name
            checked += 1
    assert checked > 80


def test_events_are_described_in_words_that_the_version_of_the_schema_has():
    schema = openapi_file.made()
    assert schema["openapi"] == "3.1.0"
    stream = schema["paths"]["/events"]["get"]["responses"]["200"]["content"]["text/event-stream"]
    assert set(stream) == {"schema"}
    assert "#/components/schemas/Event" in stream["schema"]["description"]
    assert "what" in schema["components"]["schemas"]["Event"]["properties"]

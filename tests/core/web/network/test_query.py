"""A key of the query that nobody knows is refused, with those there are."""

import importlib
import json
import pkgutil

import pytest

from platform_daemon.core.schemas.access import Role
from platform_daemon.core.web import routes
from platform_daemon.core.web.network.routes import query_keys
from platform_daemon.core.web.server import feature_routers
from tests.kit.rest import problem


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("/recordings?specimn=jewel", ["'specimn'", "say specimen", "since", "limit"]),
        ("/acquisitions?limit=3&%C3%A4=1", ["'ä'", "limit"]),
        ("/platform?x", ["'x'", "takes none"]),
        ("/fits/none/derived?Points=3", ["'Points'"]),
        ("/health?now", ["'now'"]),
    ],
)
def test_one_that_is_misspelt_would_ask_for_everything(secured, path, words):
    said = problem(secured.client.get(path, headers=secured.headers[Role.VIEWER]), 422)
    assert said["where"] == "query"
    for word in words:
        assert word in said["detail"]


def test_one_that_is_given_twice_is_not_the_last_of_both(secured):
    headers = secured.headers[Role.VIEWER]
    said = problem(secured.client.get("/recordings?sample=J-01&sample=J-02", headers=headers), 422)
    assert said["where"] == "sample"
    assert "given twice" in said["detail"]
    assert "'J-01' and 'J-02'" in said["detail"]


def test_one_that_makes_a_list_may_be_given_several_times(secured):
    found = secured.client.get("/fits/none?term=a&term=b", headers=secured.headers[Role.VIEWER])
    assert "given twice" not in found.text


def test_who_may_not_ask_hears_nothing_of_keys(secured):
    assert secured.client.get("/recordings?specimn=jewel").status_code == 401


def test_stop_looks_at_no_key(secured):
    for client in (secured.client, secured.stopping):
        assert client.post("/stop?now", headers=secured.headers[Role.VIEWER]).status_code == 200


def test_every_key_of_the_schema_is_known_and_no_other(secured):
    paths = secured.client.get("/openapi.json").json()["paths"]
    modules = [
        importlib.import_module(f"{routes.__name__}.{each.name}") for each in pkgutil.iter_modules(routes.__path__)
    ]
    routers = [*(module.router for module in modules), *feature_routers()]
    known = {
        (route.path_format, m.lower()): route for router in routers for route in router.routes for m in route.methods
    }
    found = 0
    for path, item in paths.items():
        for method, operation in item.items():
            said = {each["name"] for each in operation.get("parameters", []) if each["in"] == "query"}
            lists = {each["name"] for each in operation.get("parameters", []) if '"array"' in json.dumps(each)}
            assert query_keys(known[path, method]) == {name: name in lists for name in said}
            found += len(said)
    assert found > 30

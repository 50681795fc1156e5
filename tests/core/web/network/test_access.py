"""The table of access against every route of the schema: each role, and nobody."""

import re
from types import SimpleNamespace

import pytest
from fastapi import APIRouter
from fastapi.routing import APIRoute

from platform_daemon.core.schemas.access import Role
from platform_daemon.core.web.network.access import ACCESS, required_access, standard_access
from platform_daemon.core.web.network.routes import GuardedRoute, refuse_unguarded
from platform_daemon.core.web.server import create_api
from tests.kit.rest import problem

COMPUTES_ONLY = {"preview_schedule", "predict", "compute_defects", "draw_defects", "dry_run", "dry_run_procedure"}
OPEN = {"get_health", "get_problem_kind", "get_caller"}
NOT_IN_THE_SCHEMA = {"get_page_file"}  # files for a browser; tests/features/page is about them


def operations(client):
    """(name, method, path with ids that name nothing) of everything in the schema."""
    for path, item in client.get("/openapi.json").json()["paths"].items():
        for method, operation in item.items():
            path_to_nothing = re.sub(r"\{frame\}", "0", re.sub(r"\{(?!frame)\w+\}", "x", path))
            never_ends = operation["operationId"] == "listen"  # unless it is asked for nonsense
            yield operation["operationId"], method.upper(), path_to_nothing + "?after=x" * never_ends


@pytest.mark.parametrize("role", [None, *Role], ids=str)
def test_every_route_lets_in_the_roles_of_the_table_and_nobody_else(secured, role):
    seen = 0
    for name, method, path in operations(secured.client):
        body = {} if method == "POST" else None
        answer = secured.client.request(method, path, json=body, headers=secured.headers[role])
        needed = required_access(name).role
        if needed is None or (role is not None and role.covers(needed)):
            assert answer.status_code not in (401, 403), (name, role)
        elif role is None:
            assert answer.headers["www-authenticate"].startswith("Bearer "), name
            assert "token add" in problem(answer, 401)["remedy"]
        else:
            assert problem(answer, 403)["detail"].startswith(f"Authorization: the role {needed} is needed"), name
        seen += 1
    assert seen == len((ACCESS | standard_access()).keys() - NOT_IN_THE_SCHEMA)


@pytest.mark.parametrize("role", [None, *Role], ids=str)
def test_head_is_get_without_its_body_and_by_the_same_rules(secured, role):
    seen = 0
    for name, method, path in operations(secured.client):
        if method != "GET":
            continue
        headers = secured.headers[role]
        asked, head = (secured.client.request(m, path, headers=headers) for m in ("GET", "HEAD"))
        if name == "listen":
            assert (head.status_code, head.headers["allow"]) == (405, "GET")
            continue
        assert (head.status_code, head.content) == (asked.status_code, b""), name
        assert head.headers["content-type"] == asked.headers["content-type"], name
        assert "content-length" in head.headers, name
        seen += 1
    assert seen > 50


def test_head_is_not_in_the_schema(secured):
    assert not [item for item in secured.client.get("/openapi.json").json()["paths"].values() if "head" in item]


def test_only_an_operator_changes_anything_and_only_an_admin_what_others_rely_on(secured):
    found = {name: (method, required_access(name)) for name, method, _ in operations(secured.client)}
    for name, (method, access) in found.items():
        if method == "GET":
            assert access.role == (None if name in OPEN else Role.VIEWER), name
        elif name in COMPUTES_ONLY or name == "stop":
            assert access.role is Role.VIEWER
        else:
            assert access.role is not None
            assert access.role.covers(Role.OPERATOR), name
            assert access.audited, name
    assert {n for n, (_, a) in found.items() if a.role is Role.ADMIN} == {
        "adopt_calibration",
        "adopt_model",
        "retire_model",
    }


def test_the_schema_says_which_role_is_needed_and_how_to_show_a_token(secured):
    schema = secured.client.get("/openapi.json").json()
    assert schema["components"]["securitySchemes"]["token"]["scheme"] == "bearer"
    for item in schema["paths"].values():
        for operation in item.values():
            role = required_access(operation["operationId"]).role
            assert ("security" in operation) == (role is not None)
            assert role is None or f"Role: {role}." in operation["description"]
            assert role is None or {"401", "403"} <= set(operation["responses"])


def test_a_route_that_the_table_does_not_know_keeps_the_server_from_starting(monkeypatch):
    monkeypatch.delitem(ACCESS, "reset_amplifier")
    with pytest.raises(RuntimeError, match="reset_amplifier is not in the table of access"):
        create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None)))


@pytest.mark.parametrize(("kind", "why"), [(APIRoute, "not guarded"), (GuardedRoute, "not in the table")])
def test_a_route_beside_the_guard_or_the_table_is_refused(kind, why):
    router = APIRouter(route_class=kind)
    router.add_api_route("/back-door", lambda: None, name="back_door")
    with pytest.raises(RuntimeError, match=f"back_door is {why}"):
        refuse_unguarded(router.routes)

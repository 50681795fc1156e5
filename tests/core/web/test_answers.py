"""What the OpenAPI schema promises of every answer."""

from typing import Any

import pytest

from platform_daemon.core.registry import job_features
from tests.kit import openapi_file


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    """The schema; nothing is asked of a daemon for it."""
    return openapi_file.made()


def test_every_json_answer_has_a_named_schema(schema: dict[str, Any]) -> None:
    answers = {
        (operation["operationId"], status): response["content"]["application/json"]["schema"]
        for item in schema["paths"].values()
        for operation in item.values()
        for status, response in operation["responses"].items()
        if status.startswith("2") and "application/json" in response.get("content", {})
    }
    assert ("start_acquisition", "202") in answers
    assert [answer for answer, described in answers.items() if "$ref" not in described] == []


def described_at(schema: dict[str, Any], part: dict[str, Any], pointer: str) -> list[dict[str, Any]]:
    """What a schema describes at a JSON pointer: one description for each alternative that has that key."""
    if "$ref" in part:
        return described_at(schema, schema["components"]["schemas"][part["$ref"].rpartition("/")[2]], pointer)
    if alternatives := part.get("anyOf", part.get("oneOf", [])):
        return [found for each in alternatives for found in described_at(schema, each, pointer)]
    if not pointer:
        return [part]
    key, _, rest = pointer.partition("/")
    below = part.get("items") if key.isdigit() else part.get("properties", {}).get(key)
    return [] if below is None else described_at(schema, below, rest)


def test_every_link_takes_a_value_that_the_answer_has_for_a_parameter_that_there_is(schema: dict[str, Any]) -> None:
    operations = {o["operationId"]: o for item in schema["paths"].values() for o in item.values()}
    links = [
        (response["content"]["application/json"]["schema"], link)
        for operation in operations.values()
        for response in operation["responses"].values()
        for link in response.get("links", {}).values()
    ]
    assert len(links) > 20
    for answer, link in links:
        parameters = {each["name"] for each in operations[link["operationId"]]["parameters"] if each["in"] == "path"}
        assert set(link["parameters"]) == parameters
        for value in link["parameters"].values():
            assert described_at(schema, answer, value.removeprefix("$response.body#/")), value


@pytest.mark.parametrize("kind", [feature.kind for feature in job_features()], ids=lambda kind: kind.name)
def test_what_is_done_with_a_job_is_answered_by_the_job(schema: dict[str, Any], kind: Any) -> None:
    model = f"{''.join(part.capitalize() for part in kind.name.split('_'))}Job"
    told = [
        response["content"]["application/json"]["schema"]["$ref"]
        for path, item in schema["paths"].items()
        if path in {f"/{kind.plural}/{{identifier}}{rest}" for rest in ("", "/pause", "/resume", "/continue")}
        for operation in item.values()
        for status, response in operation["responses"].items()
        if status.startswith("2")
    ]
    assert len(told) >= 2  # GET and DELETE at least
    assert set(told) == {f"#/components/schemas/{model}"}
    shown = schema["components"]["schemas"][model]["properties"]["kind"]
    assert shown["description"] == f"{kind.article}."

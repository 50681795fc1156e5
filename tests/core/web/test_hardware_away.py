"""Whatever the owner of the hardware may raise on any path is in the schema of that path."""

import re
from typing import Any, NoReturn

import pytest
from starlette.testclient import TestClient

from drivers.errors import DeviceError, DeviceTimeout
from platform_daemon.core.hardware.catalogue import Catalogue
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.service.errors import HardwareAway
from platform_daemon.core.web.server import create_api
from platform_daemon.processes.assembly import create_context

ASKED = 48
"""Operations that the owner is asked for, at least."""


BODIES = {"reset_fault": {"by": "somebody"}}
"""Of what has no example."""


class Away:
    """An owner of which nothing comes but one error."""

    def __init__(self, error: Exception) -> None:
        self._error = error

    def invalidate(self) -> None:
        return

    def service(self, name: str) -> Any:
        return self

    def __getattr__(self, name: str) -> Any:
        def refuse(*_: object) -> NoReturn:
            raise self._error

        return refuse


def body_of(schema, operation):
    """An example of what it takes; None: it takes nothing."""
    if operation["operationId"] in BODIES:
        return BODIES[operation["operationId"]]
    content = operation.get("requestBody", {}).get("content", {}).get("application/json")
    if content is None:
        return None
    named = content["schema"]
    while "$ref" not in named and ("oneOf" in named or "anyOf" in named or "allOf" in named):
        named = next(named[key] for key in ("oneOf", "anyOf", "allOf") if key in named)[0]
    found = schema["components"]["schemas"][named["$ref"].rpartition("/")[2]] if "$ref" in named else named
    return next(iter([*found.get("examples", []), *content["schema"].get("examples", [])]), {})


@pytest.mark.long
@pytest.mark.parametrize("kind", [HardwareAway, DeviceError, DeviceTimeout])
def test_each_error_of_the_owner_is_declared_wherever_it_is_asked(tmp_path, kind):
    data = open_data_folder(tmp_path)
    context = create_context(Away(kind("gone")), data, Catalogue())
    client = TestClient(create_api(context), raise_server_exceptions=False, base_url="http://127.0.0.1")
    schema = client.get("/openapi.json").json()
    asked, undeclared = 0, []
    for path, item in schema["paths"].items():
        for method, operation in item.items():
            if operation["operationId"] == "listen":  # it never ends, and asks nobody
                continue
            there = re.sub(r"\{(\w+)\}", lambda found: "0" if found[1] == "frame" else "x", path)
            answer = client.request(method.upper(), there, json=body_of(schema, operation))
            gone = answer.json() if "problem+json" in answer.headers.get("content-type", "") else {}
            if gone.get("detail", "").startswith("gone"):
                asked += 1
                if str(answer.status_code) not in operation["responses"]:
                    undeclared.append(operation["operationId"])
    assert not undeclared
    assert asked >= ASKED
    context.close()

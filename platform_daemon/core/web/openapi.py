"""The OpenAPI schema as client generators need it: error answers by their media type, and links between operations.

FastAPI takes seconds to make it, and a generator that is started with the daemon gives up before.  So the schema is a
file of the package, and it is generated again only for an application with other operations than the file's.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute, iter_route_contexts
from pydantic import BaseModel
from starlette.routing import Route

from platform_daemon import __version__

from .network.access import Takes, required_access
from .openapi_file import OPENAPI_FILE
from .problems import MEDIA_TYPE, WHEN

# Without a type: some generators take it for that of the whole stream, which is text, others for that of an event.
EVENTS = {"description": "Server-sent events; `data` of each is JSON: `#/components/schemas/Event`."}
PROBLEM = {"$ref": "#/components/schemas/Problem"}
INVALID = {"$ref": "#/components/schemas/HTTPValidationError"}
_ID, _LABEL = {"identifier": "$response.body#/id"}, {"name": "$response.body#/label"}
_FRAME = {**_ID, "frame": "$response.body#/shots/0/frame"}
TOKEN = {
    "type": "http",
    "scheme": "bearer",
    "description": "A token of `platform-daemon token add`; on loopback only needed once there are tokens.",
}
LINKS: dict[str, dict[str, dict[str, str]]] = {  # operation -> operations that take something from its answer
    "start_acquisition": {"get_acquisition": _ID, "cancel_acquisition": _ID},
    "get_acquisition": {"get_recording": {"identifier": "$response.body#/result/recording"}},
    "start_procedure": {"get_procedure": _ID, "cancel_procedure": _ID, "pause_procedure": _ID, "resume_procedure": _ID},
    "get_procedure": {"get_recording": {"identifier": "$response.body#/result/recording"}},
    "start_calibration": {"get_calibration": _ID, "cancel_calibration": _ID, "continue_calibration": _ID},
    "start_fit": {"get_fit": _ID, "cancel_fit": _ID, "get_derived": _ID},
    "get_fit": {"get_derived": _ID, "get_envelopes": {**_ID, "frame": "$response.body#/result/frames/0/frame"}},
    "start_characterisation": {"get_characterisation": _ID, "cancel_characterisation": _ID},
    "get_characterisation": {"get_characterisation_report": _ID},
    "start_diagnosis": {"get_diagnosis": _ID, "cancel_diagnosis": _ID},
    "get_diagnosis": {"get_report": _ID, "adopt_model": _ID},
    "add_resonator": {"get_resonator": _LABEL, "get_design": _LABEL},
    "add_sequence": {"get_sequence": _LABEL},
    "adopt_model": {"get_model": _LABEL, "retire_model": _LABEL},
    "list_recordings": {"get_recording": {"identifier": "$response.body#/items/0/id"}},
    "get_recording": {
        "download_recording": _ID,
        **dict.fromkeys(("get_dmdt", "get_dmdt_npy", "get_dmdt_h5", "get_sliding", "get_harmonics"), _FRAME),
    },
}


def complete_schema(app: FastAPI) -> None:
    """Declare errors as problem details, which FastAPI declares as JSON, and add the links."""
    original = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            schema = original()
            for item in schema["paths"].values():
                for operation in item.values():
                    _complete(operation)
            for unused in ("HTTPValidationError", "ValidationError"):
                schema["components"]["schemas"].pop(unused, None)
            _complete_examples(schema["components"]["schemas"])
            schema["components"]["securitySchemes"] = {"token": TOKEN}
            app.openapi_schema = schema
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def serve_schema(app: FastAPI) -> None:
    """Answer `/openapi.json` in a thread, which needs no token.

    Where the schema has to be made, this takes seconds, in which FastAPI's own route would block the loop.
    """
    made = threading.Lock()
    cached: list[bytes] = []

    def schema(request: Request) -> Response:
        with made:
            if not cached:
                cached.append(_packaged(app) or bytes(JSONResponse(app.openapi()).body))
        return Response(cached[0], media_type=JSONResponse.media_type)

    assert app.openapi_url is not None
    others = [route for route in app.router.routes if getattr(route, "path", "") != app.openapi_url]
    app.router.routes[:] = [Route(app.openapi_url, schema, include_in_schema=False), *others]


def _packaged(app: FastAPI) -> bytes | None:
    """The schema of the package with the server's own root path; None: it describes another application."""
    packaged = OPENAPI_FILE.read_bytes()
    if not describes(packaged, app):
        return None
    if not app.servers:
        return packaged
    return json.dumps({**json.loads(packaged), "servers": app.servers}).encode()


def describes(packaged: bytes, app: FastAPI) -> bool:
    """Whether a schema has the version and just the operations of an application.

    Its models are not compared: those of the package are of the same version, and the tests compare all of it.
    """
    schema = json.loads(packaged)
    described = {each["operationId"] for item in schema["paths"].values() for each in item.values()}
    return schema["info"]["version"] == __version__ and described == operations(app)


def operations(app: FastAPI) -> set[str]:
    """The names of the operations that belong into the schema of an application."""
    routes = [context.original_route for context in iter_route_contexts(app.routes)]
    return {route.name for route in routes if isinstance(route, APIRoute) and route.include_in_schema}


def _complete(operation: dict[str, Any]) -> None:
    _secure(operation)
    for status, response in operation["responses"].items():
        stream = response.get("content", {}).get("text/event-stream", {})
        if stream.pop("itemSchema", None):  # a word of OpenAPI 3.2, and what FastAPI writes is 3.1
            stream["schema"] = EVENTS
        bodies = [content.get("schema") for content in response.get("content", {}).values()]
        if PROBLEM in bodies or INVALID in bodies:
            response["content"] = {MEDIA_TYPE: {"schema": PROBLEM}}
            response["description"] = WHEN[int(status)]
        elif int(status) < 300 and (links := _links_of(operation["operationId"])):
            response["links"] = {n: {"operationId": n, "parameters": p} for n, p in links.items()}
    operation["responses"] = dict(sorted(operation["responses"].items()))


def _complete_examples(components: dict[str, Any]) -> None:
    """Restore the keys that are null in examples, which FastAPI drops: without them an example does not validate."""
    models = {model.__name__: model for model in _subclasses(BaseModel)}
    for name, component in components.items():
        add = models[name].model_config.get("json_schema_extra") if "examples" in component else None
        if callable(add):
            add(component)  # type: ignore[call-arg]


def _subclasses(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for each in model.__subclasses__():
        yield each
        yield from _subclasses(each)


def _secure(operation: dict[str, Any]) -> None:
    """Declare the role of an operation, and the answers of the checks before it."""
    access, answers = required_access(operation["operationId"]), operation["responses"]
    statuses = [413, 421, 422, 429] + ([503] if access.takes is not Takes.NOTHING else [])
    if access.role is not None:
        # Both: whether a token is demanded is for the server to say.
        operation["security"] = [{"token": []}, {}]
        operation["description"] += f"\n\nRole: {access.role}."
        statuses += [401, 403]
    for status in statuses:
        answers.setdefault(str(status), _declared(status))
    if access.confirmed:  # optional for FastAPI, as the body may be empty; what must be is that it is said to be JSON
        operation["requestBody"]["required"] = True


def _declared(status: int) -> dict[str, Any]:
    return {"description": WHEN[status], "content": {MEDIA_TYPE: {"schema": PROBLEM}}}


def _links_of(operation: str) -> dict[str, dict[str, str]] | None:
    """What leads on from an operation: as written down, and from the start of a job to the job."""
    kind = operation.removeprefix("start_")
    if kind == operation:
        return LINKS.get(operation)
    return {f"get_{kind}": _ID, f"cancel_{kind}": _ID, **LINKS.get(operation, {})}

"""The OpenAPI schema as a generator of clients needs it."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI

from .problems import MEDIA_TYPE, WHEN

PROBLEM = {"$ref": "#/components/schemas/Problem"}


def describe_problems(app: FastAPI) -> None:
    """Have the schema say that errors are problem details: FastAPI declares them as JSON, and its own for a 422."""
    original = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            schema = original()
            for item in schema["paths"].values():
                for operation in item.values():
                    _correct(operation)
            for unused in ("HTTPValidationError", "ValidationError"):
                schema["components"]["schemas"].pop(unused, None)
            app.openapi_schema = schema
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def _correct(operation: dict[str, Any]) -> None:
    responses = operation["responses"]
    for status, response in responses.items():
        if int(status) >= 400 and int(status) != 503:
            response["content"] = {MEDIA_TYPE: {"schema": PROBLEM}}
            response["description"] = WHEN[int(status)]
    operation["responses"] = dict(sorted(responses.items()))

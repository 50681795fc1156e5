"""`python -m tests.kit.openapi_file`: write the OpenAPI schema into the package, a line for each path and model."""

from __future__ import annotations

import json
from functools import cache
from types import SimpleNamespace
from typing import Any

from platform_daemon.core.web.openapi_file import OPENAPI_FILE
from platform_daemon.core.web.server import create_api


@cache
def made() -> dict[str, Any]:
    """The schema of the application with all features, as FastAPI makes it from the code."""
    return create_api(SimpleNamespace(hardware=SimpleNamespace(outputs_off=None))).openapi()


def text_of(schema: dict[str, Any]) -> str:
    """JSON in lines that make a small difference where little has changed."""
    paths, components = schema["paths"], schema["components"]
    parts = [
        f"{json.dumps(name)}: {json.dumps(value)}" for name, value in schema.items() if value not in (paths, components)
    ]
    parts.append(f'"paths": {_lines(paths)}')
    inner = ",\n".join(f"{json.dumps(name)}: {_lines(value)}" for name, value in components.items())
    parts.append(f'"components": {{\n{inner}\n}}')
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _lines(items: dict[str, Any]) -> str:
    return "{\n" + ",\n".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in items.items()) + "\n}"


if __name__ == "__main__":
    OPENAPI_FILE.write_text(text_of(made()))

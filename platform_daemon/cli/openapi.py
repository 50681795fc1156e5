"""`platform-daemon openapi`: the schema of the REST interface, as `/openapi.json` answers it."""

from __future__ import annotations

from platform_daemon.core.web.openapi_file import OPENAPI_FILE


def openapi() -> None:
    """Print the OpenAPI schema of the REST interface, for generators of clients; no server has to run."""
    print(OPENAPI_FILE.read_text(), end="")

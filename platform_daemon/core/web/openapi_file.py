"""The OpenAPI schema as a file of the package; `python -m tests.kit.openapi_file` writes it, and a test compares it."""

from __future__ import annotations

from pathlib import Path

OPENAPI_FILE = Path(__file__).with_name("openapi.json")

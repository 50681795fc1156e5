"""Addresses that are known only when something has started: `${io_cards.0.host}` in a platform file.

`platform-daemon emulate --json F` writes F; `--endpoints F` puts its values where a platform file refers to them.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from drivers.errors import ConfigError

REFERENCE = re.compile(r"\$\{([\w.-]+)\}")
REMEDY = "start `platform-daemon emulate --config FILE --json F` and give --endpoints F"


def with_endpoints(tables: dict[str, Any], endpoints: Path | None) -> dict[str, Any]:
    """The tables with every text that is a reference replaced by its value.

    Raises ConfigError if there are references and no file, or if one refers to nothing.
    """
    known = None if endpoints is None else _read(endpoints)
    return {key: _replaced(value, known, key) for key, value in tables.items()}


def _replaced(value: Any, known: Any, where: str) -> Any:
    if isinstance(value, dict):
        return {key: _replaced(inner, known, f"{where}.{key}") for key, inner in value.items()}
    if isinstance(value, list):
        return [_replaced(inner, known, f"{where}.{k}") for k, inner in enumerate(value)]
    found = REFERENCE.fullmatch(value) if isinstance(value, str) else None
    return value if found is None else _looked_up(found[1], known, where)


def _looked_up(path: str, known: Any, where: str) -> Any:
    if known is None:
        raise ConfigError(f"{path!r} is an endpoint, and no file of endpoints was given", where=where, remedy=REMEDY)
    found = known
    for part in path.split("."):
        try:
            found = found[int(part)] if isinstance(found, list) else found[part]
        except (KeyError, IndexError, TypeError, ValueError):
            raise ConfigError(f"there is no endpoint {path!r}", where=where, remedy=REMEDY) from None
    return found


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        why = error.strerror or str(error)
        raise ConfigError("the endpoints cannot be read", where=str(path), why=why, remedy=REMEDY) from None
    except ValueError as error:
        raise ConfigError("the endpoints are not JSON", where=str(path), why=str(error), remedy=REMEDY) from None

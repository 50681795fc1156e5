"""Turns what pydantic has to say about a table into one ConfigError that names every key and its remedy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from drivers.errors import ConfigError

Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], table: Mapping[str, Any], where: str) -> Model:
    """`model` built from a TOML table.

    Raises ConfigError naming every offending key as `where.key`; no value is coerced, clamped or replaced.
    """
    try:
        return model.model_validate(table)
    except ValidationError as error:
        raise config_error(error, where) from None


def config_error(error: ValidationError, where: str) -> ConfigError:
    """All complaints of one validation as a single ConfigError."""
    complaints = [_complaint(e) for e in error.errors()]
    return ConfigError(
        "; ".join(complaints),
        where=where,
        why=f"{len(complaints)} keys are wrong" if len(complaints) > 1 else "",
        remedy="correct the key; the shipped file of the same kind has every key with its unit",
    )


def _complaint(entry: Any) -> str:
    key = ".".join(str(part) for part in entry["loc"]) or "table"
    if entry["type"] == "missing":
        return f"key {key!r} is missing"
    if entry["type"] == "extra_forbidden":
        return f"key {key!r} is unknown (value {entry['input']!r})"
    return f"key {key!r}: {entry['msg'][0].lower()}{entry['msg'][1:]}, got {entry['input']!r}"

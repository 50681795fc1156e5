"""`python -m tests.kit.request_fields`: write the table of the fields of requests that commands derive options from."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from typing_extensions import TypeAliasType

from platform_daemon.core.command_line import request_fields
from platform_daemon.core.command_line.request_fields import Limits, RequestField
from platform_daemon.core.schemas.base import attribute_docstrings
from platform_daemon.core.schemas.requests import AcquisitionRequest, CalibrationRequest
from platform_daemon.features.characterise.schema import CharacteriseRequest
from platform_daemon.features.fit.request_schema import PredictionRequest
from platform_daemon.features.ramp.schema import RampRequest
from platform_daemon.features.tune.schema import TuneRequest

MODELS = (AcquisitionRequest, CalibrationRequest, CharacteriseRequest, PredictionRequest, RampRequest, TuneRequest)
NEVER_OFFERED = ("kind", "priority", "longest_pause_s")
SCALARS = (bool, int, float, str)
BOUNDS = {"gt": ("low", True), "ge": ("low", False), "lt": ("high", True), "le": ("high", False)}


def tables() -> dict[str, dict[str, RequestField]]:
    """By name of a model and dotted key, what an option needs to know."""
    return {model.__name__: dict(fields_of(model)) for model in MODELS}


def fields_of(model: type[BaseModel], above: str = "") -> list[tuple[str, RequestField]]:
    """The fields of a model that one option can hold; those of a nested table of keys behind its name."""
    found = []
    for name, info in model.model_fields.items():
        if name in NEVER_OFFERED:
            continue
        kinds, limits, many = kinds_of(info.annotation, info.metadata)
        nested = [each for each in kinds if isinstance(each, type) and issubclass(each, BaseModel)]
        if nested == kinds and name == "sequence":
            found += fields_of(nested[0], f"{name}.")
        elif kinds and all(each in SCALARS for each in kinds):
            found.append((above + name, _field(model, name, kinds, limits, many=many, in_preset=bool(above))))
    return found


def _field(
    model: type[BaseModel], name: str, kinds: list[Any], limits: dict[str, float], *, many: bool, in_preset: bool
) -> RequestField:
    info = model.model_fields[name]
    required = info.is_required()
    default = None if required else info.default
    text, _, if_left_out = attribute_docstrings(model)[name].rstrip(".").partition("; null: ")
    if in_preset and default is None:
        if_left_out = "the preset's"
    left_out = f"; default: {if_left_out}" if if_left_out and default is None else ""
    kind = kinds[0] if len(set(kinds)) == 1 else str
    return RequestField(
        kind=kind,
        help=f"{text}{left_out}.",
        default=default,
        required=required,
        many=many,
        limits=Limits(**limits) if limits and not many else None,
    )


def kinds_of(annotation: Any, metadata: Any = ()) -> tuple[list[Any], dict[str, Any], bool]:
    """The types of a value, its limits, and whether it is a list of such values."""
    limits: dict[str, Any] = {}
    for each in metadata:
        for part in (each, *getattr(each, "metadata", ())):
            for bound, (end, is_open) in BOUNDS.items():
                if (value := getattr(part, bound, None)) is not None:
                    limits |= {end: value, f"{end}_open": is_open}
    if isinstance(annotation, TypeAliasType):
        annotation = annotation.__value__
    origin, inside = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        kinds, more, many = kinds_of(inside[0], inside[1:])
        return kinds, limits | more, many
    if origin is Literal:
        return [str], limits, False
    if origin in (Union, UnionType):
        parts = [kinds_of(each) for each in inside if each is not NoneType]
        alone = parts[0] if len(parts) == 1 else ([str], {}, False)
        return alone[0], limits | alone[1], alone[2]
    if (origin in (tuple, list) and isinstance(inside[0], type)) or get_origin(
        inside[0] if inside else None
    ) is Annotated:
        kinds, _, _ = kinds_of(inside[0])
        return kinds, {}, True
    return ([annotation] if origin is None else []), limits, False


def written(value: Any) -> str:
    """As Python reads it; what is at its default is left out."""
    if isinstance(value, dict):
        return f"{{{','.join(f'{key!r}: {written(each)}' for key, each in value.items())}}}"
    if is_dataclass(value) and not isinstance(value, type):
        said = [each for each in fields(value) if getattr(value, each.name) != each.default]
        return f"{type(value).__name__}({', '.join(f'{e.name}={written(getattr(value, e.name))}' for e in said)})"
    return value.__name__ if isinstance(value, type) else repr(value)


def main() -> None:
    """Write the table where the command line reads it."""
    path = Path(request_fields.__file__)
    head = path.read_text(encoding="utf-8").partition("REQUEST_FIELDS")[0]
    text = written(tables())
    path.write_text(f"{head}REQUEST_FIELDS: dict[str, dict[str, RequestField]] = {text}\n", encoding="utf-8")
    subprocess.run([sys.executable, "-m", "ruff", "format", path], check=True)


if __name__ == "__main__":
    main()

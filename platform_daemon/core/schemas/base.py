"""What all schemas share: one base class, one way to leave a key out, one way to write JSON."""

from __future__ import annotations

import ast
import inspect
import itertools
import json
import math
import re
import textwrap
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, TypeVar, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, GetJsonSchemaHandler, RootModel, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema
from typing_extensions import TypeAliasType

from .control_characters import encodable

T = TypeVar("T")
EXAMPLES = Path(__file__).parent / "examples"

Verdict = TypeAliasType("Verdict", Literal["good", "refused"])
"""Whether there is a result, or a reason why there is none."""
FitVerdict = TypeAliasType("FitVerdict", Literal["good", "refused", "blank"])
"""The same of a shot; blank: it was made without excitation, so that there is nothing to find."""
ClockKind = TypeAliasType("ClockKind", Literal["real", "simulated"])
"""Clock of a platform. simulated: that of a simulated one, which passes faster or slower than the time of this
computer, or begins on another date."""
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
NamedWindow = TypeAliasType("NamedWindow", Literal["n50", "d30"])
Window = NamedWindow | Positive
"""Evaluation window: "n50" (the first 0.24 s), "d30" (until 30 % of the maximum is left), or seconds."""
Vector = Annotated[tuple[float, ...], Field(min_length=3, max_length=3)]
"""Three components, x, y, z."""
Interval = Annotated[tuple[float, ...], Field(min_length=2, max_length=2)]
"""Lowest and highest value."""


class Schema(BaseModel):
    """Something that crosses a boundary: REST, a file, the command line.

    Immutable; unknown keys are refused; the keys of its JSON come in the order of its fields.  A field `X | None`
    is always written, null where there is nothing to say; an `Absent[X]` is not written at all where it is None.
    Every field has a docstring with its unit: it becomes the description in the OpenAPI schema.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        defer_build=True,  # a command pays for the schemas that it uses, not for all
        validate_by_name=True,
        validate_by_alias=True,
        serialize_by_alias=True,
    )

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        found = handler(core)
        properties = handler.resolve_ref_schema(found).get("properties", {})
        for name, info in cls.model_fields.items():
            text = attribute_docstrings(cls).get(name)
            if text is None:  # a field of a class that is made at run time describes itself
                continue
            key = info.serialization_alias or name
            if key in properties:
                properties[key]["description"] = text
        return found


@cache
def attribute_docstrings(cls: type[BaseModel]) -> dict[str, str]:
    """Field -> the text below it, of a class and those that it is made from.

    Read from the source when a JSON schema is made: pydantic's own `use_attribute_docstrings` reads it at import, which
    every command would pay for with more than all the classes take to be made.
    """
    found: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        if not issubclass(base, Schema) or "[" in base.__name__:  # Job[...] is written down as Job
            continue
        try:
            definition = ast.parse(textwrap.dedent(inspect.getsource(base))).body[0]
        except OSError:  # a class that is made at run time describes each of its fields itself
            for name in inspect.get_annotations(base):
                found.pop(name, None)
            continue
        assert isinstance(definition, ast.ClassDef)
        for field, text in itertools.pairwise(definition.body):
            if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
                found[ast.unparse(field.target)] = " ".join(str(text.value.value).split())
    return found


def _whole(value: Any) -> Any:
    """JSON has one kind of numbers, and 3.0 is a whole one (JSON Schema 2020-12, 6.1.1)."""
    if isinstance(value, list | tuple):
        return type(value)(_whole(each) for each in value) if type(value) in (list, tuple) else value
    exact = isinstance(value, float) and abs(value) < _EXACT and value.is_integer()
    return int(value) if exact else value


_EXACT = 2.0**53
"""Below it every whole number is a float of its own."""


@cache
def _whole_fields(cls: type[BaseModel]) -> frozenset[str]:
    """The keys of a model that take whole numbers and no others."""
    found: set[str] = set()
    for name, info in cls.model_fields.items():
        kinds = set(_leaves(info.annotation))
        if int in kinds and float not in kinds:
            found |= {name, info.alias or name}
    return frozenset(found)


def _leaves(annotation: Any) -> Iterator[Any]:
    if isinstance(annotation, TypeAliasType):
        yield from _leaves(annotation.__value__)
    elif parts := get_args(annotation):
        for part in parts:
            yield from _leaves(part)
    else:
        yield annotation


class Request(Schema):
    """A request: no value is coerced, but a whole number may be written 3.0."""

    # Made at once: FastAPI, which silences what pydantic warns of while it builds the parameter of a route, would not
    # be there when a deferred one is built.
    model_config = ConfigDict(strict=True, defer_build=False)

    @model_validator(mode="before")
    @classmethod
    def _whole_numbers(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        whole = _whole_fields(cls)
        return {key: _whole(value) if key in whole else value for key, value in data.items()}


def _is_zero(value: Any) -> bool:
    return bool(value == 0)


Priority = Annotated[int, Field(ge=-100, le=100)]
"""Of several that wait the highest begins first."""


class QueuedRequest(Request):
    """What waits for the platform, if others are there before it."""

    priority: Annotated[Priority, Field(exclude_if=_is_zero)] = 0
    """Of several that wait the highest begins first, of equal ones the one that was requested first; -100 to 100.  It
    is not written where it is 0."""

    @property
    def mounted_resonator(self) -> str | None:
        """Name of the resonator that must be mounted for it; None: any."""
        return None


class Root(RootModel[T], Generic[T]):
    """Something whose JSON is a list, a mapping, or one of several schemas."""

    model_config = ConfigDict(frozen=True, defer_build=True)


class NoResult(Schema):
    """There is no result: not yet, or the job ended without one."""


class ListPage(Schema, Generic[T]):
    """A page of a list: every list that REST answers with has this form."""

    items: tuple[T, ...]
    """The entries of this page, in the order of the list."""
    next: str | None = None
    """Path of the next page, as in the header Link; null: this is the last one."""


def _is_none(value: Any) -> bool:
    return value is None


def _never_null(schema: dict[str, Any]) -> None:
    """Of a key that may be missing: what it is where it is there."""
    schema.pop("default", None)
    kinds = [kind for kind in schema.get("anyOf", ()) if kind != {"type": "null"}]
    if len(kinds) == 1:
        del schema["anyOf"]
        schema.update(kinds[0])
    elif kinds:
        schema["anyOf"] = kinds


Absent = Annotated[T | None, Field(exclude_if=_is_none, json_schema_extra=_never_null)]
"""A key that may be missing; give it the default None."""


def _not_null(value: Any) -> Any:
    if value is None:
        raise ValueError("null says nothing: leave the key out")
    return value


Given = Annotated[T | None, BeforeValidator(_not_null), Field(exclude_if=_is_none, json_schema_extra=_never_null)]
"""A key of a request that may be left out, but not be null; give it the default None."""


def _finite_or_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


FiniteOrNull = Annotated[float | None, BeforeValidator(_finite_or_none)]
"""A number; null in the place of what JSON cannot hold: NaN and infinity."""


def example(*names: str, listed: bool = False) -> Callable[[dict[str, Any]], None]:
    """For `json_schema_extra`: the examples of these names, read when a schema is made and not before.

    listed: as the one entry of a page of a list.
    """

    def add(schema: dict[str, Any]) -> None:
        found = [json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8")) for name in names]
        schema["examples"] = [{"items": found, "next": None}] if listed else found

    return add


def to_json(content: Schema | Root[Any], *, indent: int | None = None, allow_nan: bool = False) -> str:
    """The JSON text of files and of the command line; floats as Python prints them, text as `encodable`.

    Raises ValueError for NaN or infinity, unless `allow_nan`: then they are written as Python's json reads them.
    """
    text = json.dumps(content.model_dump(), indent=indent, allow_nan=allow_nan)
    return _ESCAPES.sub(_without_halves, text) if "\\ud" in text else text


_ESCAPES = re.compile(r"\\\\|\\ud[89ab]..\\ud[c-f]..|\\u(d[89a-f]..)")
"""In JSON: a backslash, a character of two halves, and a half that stands alone."""


def _without_halves(found: re.Match[str]) -> str:
    return found[0] if found[1] is None else json.dumps(encodable(chr(int(found[1], 16))))[1:-1]

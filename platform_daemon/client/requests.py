"""Requests from keyword arguments: flat names, people's units, ranges; and what help() says of each of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_origin

from pydantic import BaseModel

from drivers.errors import ConfigError, InputError
from drivers.text_files import read_text_file
from drivers.validation import validated
from platform_daemon.core.schemas.base import attribute_docstrings
from platform_daemon.features.sweep.keys import keys_of

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])
ModelT = TypeVar("ModelT", bound=BaseModel)
_ARGUMENTS = "Arguments; what is not given is as the daemon has it:"
_KEY = "    idempotency_key: A call that is repeated with it returns the first job; None: a new one."
_UNITS = "Keys in T, s, Hz and rad may also be given as NAME_ut, NAME_mt, NAME_ms, NAME_khz and NAME_deg."
_LIMITS = {"gt": "above {}", "ge": "at least {}", "lt": "below {}", "le": "at most {}"}


def several(value: str | Sequence[str]) -> tuple[str, ...]:
    """One value, or several, as several."""
    return (value,) if isinstance(value, str) else tuple(value)


def text_of(path: Path, where: str) -> str:
    """The text of a file that becomes a value of a request.  Raises InputError for one that cannot be read."""
    try:
        return read_text_file(path)
    except (OSError, ValueError) as error:
        remedy = "give the path of a file in UTF-8, or the text itself"
        raise InputError("the file cannot be read", where=where, why=str(error), remedy=remedy) from None


def request_from(
    model: type[ModelT], values: Mapping[str, Any], where: str, *, base: BaseModel | None = None
) -> ModelT:
    """The request with these values; base: one whose other values it has, None: the defaults.

    values: by the names of `keys_of`: `field_t`, `sequence.field_t` and `field_ut` are the same key.
    Raises InputError for a name that is no key, a key that is given twice, or a value that is none.
    """
    keys, table = keys_of(model), {} if base is None else base.model_dump()
    taken: dict[tuple[str, ...], str] = {}
    found: list[tuple[tuple[str, ...], str, Any]] = []
    for name, value in values.items():
        key = keys.get(name)
        if key is None and name not in model.model_fields:
            near = get_close_matches(name, [each for each in keys if "." not in each], 3)
            remedy = f"did you mean {' or '.join(near)}?" if near else f"help({where}) lists what there is"
            raise InputError(f"there is no argument {name!r}", where=where, remedy=remedy)
        path = (name,) if key is None else key.path
        if path in taken:
            raise _twice(name, taken[path], where)
        taken[path] = name
        found.append((path, name, _plain(value if key is None else key.value(value))))
    for path, name, value in sorted(found, key=lambda each: len(each[0])):  # a table before what is added to it
        place: dict[str, Any] = table
        for k, part in enumerate(path[:-1], start=1):
            if isinstance(place.get(part), BaseModel):
                place[part] = place[part].model_dump(exclude_unset=True)
            place = place.setdefault(part, {})
            if path[:k] in taken and path[k] in place:
                raise _twice(name, f"{path[k]} of {taken[path[:k]]}", where)
        place[path[-1]] = value
    try:
        return validated(model, table, where)
    except ConfigError as error:
        remedy = f"help(Client.{where}) says of every argument what it means, its unit and its limits"
        raise InputError(error.what, where=error.where, why=error.why, remedy=remedy) from None


def _twice(name: str, other: str, where: str) -> InputError:
    return InputError(f"{name} and {other} are the same", where=where, remedy="give one of the two")


def _plain(value: Any) -> Any:
    """Ranges, arrays and numbers of numpy as lists and numbers."""
    if isinstance(value, BaseModel | str | bytes):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, Iterable) else value


def axes(over: Mapping[str, Iterable[Any]] | Iterable[Mapping[str, Any]]) -> list[Any]:
    """The axes of a sweep, from `{"field_ut": range(50, 301, 50)}` or as a request has them."""
    if not isinstance(over, Mapping):
        return [_plain(each) for each in over]
    return [{"key": key, "values": _plain(values)} for key, values in over.items()]


def takes(model: type[BaseModel], *leave_out: str) -> Callable[[FunctionT], FunctionT]:
    """Give a method whose keywords become a request their names for completion, and a help text with units and limits.

    leave_out: keys that the method fills in itself.
    """

    def described(function: FunctionT) -> FunctionT:
        signature = inspect.signature(function)
        own = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
        named, said = {each.name for each in own}, inspect.getdoc(function) or ""
        known = {*leave_out, *(name for name in named if f"{name}: " in said)}
        lines, keywords = [], []
        for name, text, kind in _fields(model):
            if name not in known:
                known.add(name)
                lines.append(f"    {name}: {text}")
                if name not in named:
                    key = inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=..., annotation=kind)
                    keywords.append(key)
        if "idempotency_key" in named:
            lines.append(_KEY)
        function.__doc__ = "\n".join((said, "", _ARGUMENTS, *lines, "", _UNITS, ""))
        rest = [each for each in signature.parameters.values() if each.kind is inspect.Parameter.VAR_KEYWORD]
        function.__signature__ = signature.replace(parameters=[*own, *keywords, *rest])  # type: ignore[attr-defined]
        return function

    return described


def _fields(model: type[BaseModel]) -> list[tuple[str, str, Any]]:
    """Name, text with limits, and type of each key of a request and of what it nests, from the outside inwards."""
    own, inner = [], []
    texts = attribute_docstrings(model)
    for name, field in model.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            inner += _fields(kind)
        else:
            own.append((name, " ".join(filter(None, (texts.get(name, ""), _limits(kind, field.metadata)))), kind))
    return own + inner


def _limits(kind: Any, metadata: Iterable[Any]) -> str:
    """As `[above 0, at most 1]`; empty: any value of that type."""
    marks = [*metadata, *_marks(kind)]
    found = {text: getattr(mark, limit) for limit, text in _LIMITS.items() for mark in marks if hasattr(mark, limit)}
    return f"[{', '.join(text.format(f'{value:g}') for text, value in found.items())}]" if found else ""


def _marks(kind: Any) -> list[Any]:
    """The constraints inside of a type, as of `Annotated[float, Field(gt=0)] | None`."""
    if get_origin(kind) is Annotated:
        inner, *marks = get_args(kind)
        return [*(each for mark in marks for each in getattr(mark, "metadata", (mark,))), *_marks(inner)]
    return [mark for each in get_args(kind) for mark in _marks(each)]

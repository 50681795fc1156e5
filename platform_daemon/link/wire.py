"""How calls become lines: one line of JSON for a call, one for its answer, typed on both sides by the contract."""

from __future__ import annotations

import inspect
import json
from dataclasses import dataclass
from functools import cache
from types import GenericAlias
from typing import Any, cast, get_type_hints

from pydantic import TypeAdapter

from platform_daemon.schemas import JobSnapshot, Root, Schema

from . import hardware
from .jobs import ShownJob


@dataclass(frozen=True)
class Method:
    """One method of the contract: types of its arguments, and of what it answers."""

    arguments: TypeAdapter[Any]
    answer: TypeAdapter[Any]

    def read_arguments(self, told: tuple[Any, ...]) -> tuple[Any, ...]:
        """Raises ValueError for arguments of other types."""
        found: tuple[Any, ...] = self.arguments.validate_json(_text(told))
        return found

    def written(self, value: Any) -> Any:
        """A value of the answer's type as JSON."""
        return self.answer.dump_python(_as_snapshot(value))

    def read(self, told: Any) -> Any:
        """The value again."""
        return _from_snapshot(self.answer.validate_json(_text(told)))


@cache
def methods() -> dict[str, Method]:
    """By name, as the contract declares them."""
    return {
        name: _method(function)
        for name, function in inspect.getmembers(hardware.Hardware, inspect.isfunction)
        if not name.startswith("_")
    }


def _method(function: Any) -> Method:
    hints = get_type_hints(function)
    answer = hints.pop("return")
    arguments = tuple(hints[name] for name in inspect.signature(function).parameters if name != "self")
    told = {ShownJob: JobSnapshot, tuple[ShownJob, ...]: tuple[JobSnapshot, ...]}.get(answer, answer)
    return Method(TypeAdapter(cast(Any, GenericAlias(tuple, arguments))), TypeAdapter(told))


def _as_snapshot(value: Any) -> Any:
    if isinstance(value, ShownJob):
        return value.snapshot()
    return tuple(map(_as_snapshot, value)) if isinstance(value, tuple) else value


def _from_snapshot(value: Any) -> Any:
    if isinstance(value, JobSnapshot):
        return ShownJob.from_snapshot(value)
    return tuple(map(_from_snapshot, value)) if isinstance(value, tuple) else value


def _text(value: Any) -> str:
    return json.dumps(value)  # NaN as Python writes it, which pydantic reads


def plain(argument: Any) -> Any:
    """An argument as it goes over the wire."""
    return argument.model_dump() if isinstance(argument, Schema | Root) else argument

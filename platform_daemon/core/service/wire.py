"""How calls become lines: one line of JSON for a call, one for its answer, typed on both sides by the contract.

Each is serialised once, by the connection that sends it, and validated once, by the methods here, against the types of
the contract.

A service is a Protocol; a method's name goes over the wire as "method" for the platform service and as "feature.method"
for the service of a feature.  `request: Any` is of the model of the kind that the call names.
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from functools import cache
from types import GenericAlias
from typing import Any, cast, get_type_hints

from pydantic import TypeAdapter

from platform_daemon.core.jobs.kinds import request_adapter
from platform_daemon.core.registry import feature_of, features
from platform_daemon.core.schemas.base import Schema

from .job_view import JobView
from .platform_service import PlatformService, Repeat


@dataclass(frozen=True, kw_only=True)
class Method:
    """One method of a service: the types of its arguments and of its answer, and how it may be repeated."""

    arguments: TypeAdapter[Any]
    answer: Any
    repeat: Repeat
    names: tuple[str, ...]

    def read_arguments(self, sent: tuple[Any, ...]) -> tuple[Any, ...]:
        """Raises ValueError for arguments of other types, InputError for a kind that there is not."""
        found = list(self.arguments.validate_python(sent))
        if "kind" in self.names and "request" in self.names:
            at = self.names.index("request")
            found[at] = request_adapter(found[self.names.index("kind")]).validate_python(sent[at])
        return tuple(found)

    def write_answer(self, value: Any) -> Any:
        """A value of the answer's type, made of schemas and plain values that the connection serialises."""
        if self.answer is JobView:
            return value.to_wire()
        if self.answer == tuple[JobView, ...]:
            return [each.to_wire() for each in value]
        return value

    def read_answer(self, sent: Any, arguments: tuple[Any, ...]) -> Any:
        """The value again.  Raises ValueError."""
        if self.answer is JobView:
            return JobView.from_wire(sent)
        if self.answer == tuple[JobView, ...]:
            return tuple(JobView.from_wire(each) for each in sent)
        if self.answer is Schema:
            feature = feature_of(arguments[self.names.index("kind")])
            return feature.load(feature.kind.summary).model_validate(sent)
        return _adapter(self.answer).validate_python(sent)


@cache
def services() -> dict[str, Any]:
    """The contracts by name: "" is the platform service, the others are those of features."""
    found: dict[str, Any] = {"": PlatformService}
    for each in features():
        if each.service:
            found[each.package.rpartition(".")[2]] = each.load(each.service)
    return found


@cache
def methods() -> dict[str, Method]:
    """All methods of all services by their names on the wire."""
    return {
        f"{service}.{name}" if service else name: _method(function)
        for service, contract in services().items()
        for name, function in inspect.getmembers(contract, inspect.isfunction)
        if not name.startswith("_")
    }


def _method(function: Any) -> Method:
    hints = get_type_hints(function)
    answer = hints.pop("return")
    names = tuple(name for name in inspect.signature(function).parameters if name != "self")
    arguments = tuple(hints[name] for name in names)
    return Method(
        arguments=TypeAdapter(cast(Any, GenericAlias(tuple, arguments))),
        answer=answer,
        repeat=getattr(function, "repeat", Repeat.CHECK),
        names=names,
    )


@cache
def _adapter(answer: Any) -> TypeAdapter[Any]:
    return TypeAdapter(answer)

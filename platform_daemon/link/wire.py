"""How calls become lines: one line of JSON for a call, one for its answer, typed on both sides by the contract."""

from __future__ import annotations

import contextlib
import inspect
import json
import select
import socket
from dataclasses import dataclass
from functools import cache
from types import GenericAlias
from typing import Any, cast, get_type_hints

from pydantic import TypeAdapter

from drivers.errors import DeviceProtocolError
from platform_daemon.schemas import JobSnapshot, LinkAnswer, LinkCall, to_json

from . import hardware
from .jobs import ShownJob

LONGEST = 256 * 1024 * 1024
"""Bytes of a line: a job with the fits of some ten thousand shots; whatever is longer is no message of ours."""


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


class Line:
    """One end of a connection.  Not for several threads at once."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._file = connection.makefile("rb")

    def send(self, message: LinkCall | LinkAnswer) -> None:
        """Raises OSError."""
        self._socket.sendall(to_json(message, allow_nan=True).encode() + b"\n")

    def call(self) -> LinkCall | None:
        """The next call; None: the other end has gone.  Raises OSError, DeviceProtocolError."""
        line = self._line()
        return None if line is None else LinkCall.model_validate_json(line)

    def answer(self) -> LinkAnswer | None:
        """The answer to what was sent; None: the other end has gone.  Raises OSError, DeviceProtocolError."""
        line = self._line()
        return None if line is None else LinkAnswer.model_validate_json(line)

    def is_stale(self) -> bool:
        """Has the other end gone, or said what nobody asked?"""
        return bool(select.select([self._socket], [], [], 0)[0])

    def close(self) -> None:
        """Idempotent."""
        with contextlib.suppress(OSError):
            self._file.close()
        self._socket.close()

    def _line(self) -> bytes | None:
        line = self._file.readline(LONGEST)
        if line and not line.endswith(b"\n") and len(line) >= LONGEST:
            raise DeviceProtocolError("a message is too long", where="hardware.sock")
        return line if line.endswith(b"\n") else None

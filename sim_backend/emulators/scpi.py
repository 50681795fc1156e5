"""Headers of SCPI commands: full or short keywords in any case, numbers glued on; an unknown header is not found."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

Handler = TypeVar("Handler", bound=Callable[..., object])

_KEYWORD = re.compile(r"([A-Z*]+)([A-Za-z]*)(#?)")


class CommandTable(Generic[Handler]):
    """Patterns like `RP:ADC:DECimation` or `OUTPut?` and their handlers, in order: the first that fits wins.

    The short form of a keyword is its leading run of capitals; `#` takes a number glued on (none: the default, 1).
    """

    def __init__(self, commands: Mapping[str, Handler]) -> None:
        self._commands = [(re.compile(_expression(p), re.IGNORECASE), handler) for p, handler in commands.items()]

    def find(self, header: str) -> tuple[Handler, tuple[int, ...]] | None:
        """The handler and the numbers in the header; None for an unknown header."""
        for expression, handler in self._commands:
            if found := expression.fullmatch(header.removeprefix(":")):
                return handler, tuple(int(n) if n else 1 for n in found.groups())
        return None


def _expression(pattern: str) -> str:
    body, query = (pattern[:-1], r"\?") if pattern.endswith("?") else (pattern, "")
    return ":".join(_keyword(k) for k in body.split(":")) + query


def _keyword(keyword: str) -> str:
    found = _KEYWORD.fullmatch(keyword)
    if found is None:
        raise ValueError(f"{keyword!r} is no keyword")
    short, rest, number = found.groups()
    either = re.escape(short) + (f"(?:{re.escape(rest)})?" if rest else "")
    return either + (r"(\d*)" if number else "")


def split(command: str) -> tuple[str, list[str]]:
    """Header and arguments; one blank separates them, commas separate arguments."""
    header, *rest = command.split(maxsplit=1)
    return header, [a.strip() for a in rest[0].split(",")] if rest else []

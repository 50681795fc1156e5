"""What commands print reaches the terminal as text: a name in a file must not move its cursor or fill its clipboard.

Only rich, which draws tables and bars, writes to the terminal itself; who hands it a name makes that printable first.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from platform_daemon.schemas import printable


class PlainText:
    """A stream of which control characters are written out, but for newline and tab; all else is that of `stream`."""

    def __init__(self, stream: TextIO) -> None:
        self.rich_proxied_file = for_rich(stream)  # rich asks for it by this name
        self._stream = stream

    def write(self, text: str) -> int:
        """As of any text stream."""
        return self._stream.write(printable(text))

    def writelines(self, lines: Iterable[str]) -> None:
        """As of any text stream."""
        self.write("".join(lines))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def for_rich(stream: TextIO) -> TextIO:
    """The stream behind all that was put before it, by this module and by rich."""
    while (behind := getattr(stream, "rich_proxied_file", stream)) is not stream:
        stream = behind
    return stream


@contextmanager
def plain_text_only() -> Iterator[None]:
    """Of all that is printed meanwhile."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = PlainText(sys.stdout), PlainText(sys.stderr)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before

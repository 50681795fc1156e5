"""What commands print reaches the terminal as text, and what it does not take ends no command.

A name in a file must not move its cursor or fill its clipboard.  Only rich, which draws tables and bars, writes to the
terminal itself; who hands it a name makes that printable first.

A pipe without a reader and a full disk under a redirected log lose what is printed, and an encoding without a character
has a question mark in its place.  Exit code and files of a command are what they would be otherwise.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

from platform_daemon.core.schemas.control_characters import printable


class TolerantStream:
    """The stream behind it, of which a write that fails is lost."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.error: OSError | None = None
        """The first failure; None: all was written."""

    def write(self, text: str) -> int:
        """As of any text stream.  Raises nothing."""
        try:
            self._stream.write(text)
        except UnicodeEncodeError:
            self.write(text.encode(self._stream.encoding, "replace").decode(self._stream.encoding))
        except OSError as error:
            self._lose(error)
        return len(text)

    def flush(self) -> None:
        """As of any text stream.  Raises nothing."""
        try:
            self._stream.flush()
        except OSError as error:
            self._lose(error)

    def _lose(self, error: OSError) -> None:
        self.error = self.error or error
        if error.errno == errno.EPIPE:  # for good: the reader does not come back
            self.discard()

    def discard(self) -> None:
        """Lose what the buffer of the stream still holds, which Python would try to write again at exit."""
        with suppress(OSError, ValueError):  # the latter: it is no file
            nowhere = os.open(os.devnull, os.O_WRONLY)
            try:
                os.dup2(nowhere, self._stream.fileno())
            finally:
                os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


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


@contextmanager
def tolerant_streams() -> Iterator[None]:
    """Nothing that is printed meanwhile fails.  At the end, one line on stderr says what was lost, and why."""
    before = sys.stdout, sys.stderr
    out, err = TolerantStream(sys.stdout), TolerantStream(sys.stderr)
    sys.stdout, sys.stderr = out, err
    try:
        yield
    finally:
        out.flush()
        if out.error is not None and out.error.errno != errno.EPIPE:
            err.write(f"warning: not all of the output was written: {out.error.strerror or out.error}\n")
        err.flush()
        for stream in (out, err):
            if stream.error is not None:
                stream.discard()
        sys.stdout, sys.stderr = before


def print_kept_nowhere(text: str) -> None:
    """Print what is in no file, so that the command fails if it cannot be printed.  Raises OSError."""
    print(text)
    sys.stdout.flush()
    error = getattr(sys.stdout, "error", None)
    if isinstance(error, OSError):
        raise OSError(error.errno, error.strerror, "standard output")

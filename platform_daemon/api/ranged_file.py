"""A file as an answer, whole or in ranges (RFC 9110, 14).

Starlette's own refuses a Range that it does not understand, which is to be ignored, and all ranges where one begins
behind the end of the file.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from fastapi.responses import FileResponse
from starlette.datastructures import Headers
from starlette.types import Message, Receive, Scope, Send

from drivers.errors import InputError

from .problems import problems

BINARY = {"schema": {"type": "string", "format": "binary"}}
PART = re.compile(r"([0-9]{1,100})-([0-9]{1,100})?|-([0-9]{1,100})")
MULTIPART = "multipart/byteranges"


class RangeNotSatisfiable(InputError):
    """No part of the file is in the range of bytes that was asked for."""

    title = "Range not satisfiable"

    def __init__(self, size: int) -> None:
        which = f"for bytes from 0 to {size - 1}, or " if size else ""
        remedy = f"ask {which}without Range for the whole file"
        super().__init__("the file ends before the range begins", where="Range", remedy=remedy)
        self.headers = {"Content-Range": f"bytes */{size}"}


class RangedFile(FileResponse):
    """A file that is there.  Raises RangeNotSatisfiable, before anything is sent."""

    def __init__(self, path: Path, media_type: str, filename: str | None = None) -> None:
        found = path.stat()
        super().__init__(path, media_type=media_type, filename=filename, stat_result=found)
        self._size = found.st_size

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""

        async def sent(message: Message) -> None:
            if message.get("status") == 416:
                raise RangeNotSatisfiable(self._size)
            await send(message)

        asked = Headers(scope=scope).get("range") if scope["method"] == "GET" else None  # it means nothing else
        headers = [each for each in scope["headers"] if each[0] != b"range"]
        found = None if asked is None else within(asked, self._size)
        if found is not None:
            headers.append((b"range", found.encode()))
        await super().__call__({**scope, "headers": headers}, receive, sent)


def within(asked: str, size: int) -> str | None:
    """A Range without the parts that are not in the file; all of them if none is; None: it is to be ignored."""
    unit, _, listed = asked.partition("=")
    texts = [text for each in listed.split(",") if (text := each.strip())]
    parts = [found.groups() for text in texts if (found := PART.fullmatch(text))]
    if unit.strip().lower() != "bytes" or not parts or len(parts) < len(texts):
        return None
    if any(first and last and int(last) < int(first) for first, last, _ in parts):
        return None
    there = [text for text, part in zip(texts, parts, strict=True) if _begins_in(part, size)]
    return f"bytes={','.join(there or texts)}"


def _begins_in(part: tuple[str | None, ...], size: int) -> bool:
    first, _, suffix = part
    return int(first) < size if first else int(suffix or 0) > 0


def ranged(content: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    """What a route declares that answers with such a file, beside 200; content: by its media type."""
    parts = {**content, MULTIPART: BINARY}
    return {206: {"content": parts, "description": "What Range asks for; of several parts multipart"}, **problems(416)}

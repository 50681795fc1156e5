"""A file as an answer, whole or in ranges (RFC 9110, 14), with its SHA-256 where `Want-Repr-Digest` asks for it (RFC
9530).

Starlette's own refuses a Range that it does not understand, which is to be ignored, and all ranges where one begins
behind the end of the file.
"""

from __future__ import annotations

import base64
import hashlib
import re
from functools import lru_cache
from pathlib import Path
from typing import Any

from fastapi.responses import FileResponse
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.types import Message, Receive, Scope, Send

from drivers.errors import InputError

from .problems import problems

BINARY = {"schema": {"type": "string", "format": "binary"}}
PART = re.compile(r"([0-9]{1,100})-([0-9]{1,100})?|-([0-9]{1,100})")
MULTIPART = "multipart/byteranges"


class RangeNotSatisfiable(InputError):
    """No part of the file is in the requested range of bytes."""

    title = "Range not satisfiable"
    http_status = 416

    def __init__(self, size: int) -> None:
        which = f"for bytes from 0 to {size - 1}, or " if size else ""
        remedy = f"ask {which}without Range for the whole file"
        super().__init__("the file ends before the range begins", where="Range", remedy=remedy)
        self.headers = {"Content-Range": f"bytes */{size}"}


class RangedFile(FileResponse):
    """An existing file.  Raises RangeNotSatisfiable, before anything is sent."""

    def __init__(self, path: Path, media_type: str, filename: str | None = None) -> None:
        found = path.stat()
        self._file = path
        super().__init__(path, media_type=media_type, filename=filename, stat_result=found)
        self._size, self._modified_ns = found.st_size, found.st_mtime_ns

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""

        async def sent(message: Message) -> None:
            if message.get("status") == 416:
                raise RangeNotSatisfiable(self._size)
            await send(message)

        requested = Headers(scope=scope).get("range") if scope["method"] == "GET" else None  # of no other method
        if "sha-256" in Headers(scope=scope).get("want-repr-digest", ""):
            self.headers["Repr-Digest"] = await run_in_threadpool(_digest, self._file, self._size, self._modified_ns)
        headers = [each for each in scope["headers"] if each[0] != b"range"]
        found = None if requested is None else within(requested, self._size)
        if found is not None:
            headers.append((b"range", found.encode()))
        await super().__call__({**scope, "headers": headers}, receive, sent)


@lru_cache(maxsize=64)  # a download that is continued asks for each of its ranges
def _digest(path: Path, size: int, modified_ns: int) -> str:
    with path.open("rb") as file:
        found = hashlib.file_digest(file, "sha256").digest()
    return f"sha-256=:{base64.b64encode(found).decode()}:"


def within(requested: str, size: int) -> str | None:
    """A Range without the parts outside the file, or with all of them if none is inside; None: to be ignored."""
    unit, _, listed = requested.partition("=")
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
    """The answers, other than 200, that a route with such a file declares; content: by its media type."""
    parts = {**content, MULTIPART: BINARY}
    return {206: {"content": parts, "description": "What Range asks for; of several parts multipart"}, **problems(416)}


PNG: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}}
}

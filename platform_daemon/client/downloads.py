"""Downloads in ranges: how far one is, and whether it is the file that the daemon has."""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path

import httpx2

from .errors import ChecksumMismatch

_SHA256 = re.compile(r"sha-256=:([A-Za-z0-9+/=]+):")
TRIES, PAUSE_S = 20, 0.5
"""How often a download that is cut off is continued without a byte in between, and after what time, s."""


class Download:
    """A file that grows next to its target, and takes its name once it is whole and right."""

    def __init__(self, target: Path) -> None:
        self.target, self._part = target, target.with_name(f".{target.name}.part")
        self._etag = self._digest = ""
        self._size: int | None = None
        self._part.unlink(missing_ok=True)

    @property
    def done(self) -> int:
        """Bytes so far."""
        return self._part.stat().st_size if self._part.exists() else 0

    @property
    def complete(self) -> bool:
        """Whether every byte is there."""
        return self._size is not None and self.done == self._size

    def headers(self) -> dict[str, str]:
        """What the next request says: which bytes are missing, of which version of the file."""
        headers = {"Want-Repr-Digest": "sha-256=10", "Accept-Encoding": "identity"}
        if self.done:
            headers |= {"Range": f"bytes={self.done}-", "If-Range": self._etag}
        return headers

    def begin(self, response: httpx2.Response) -> None:
        """An answer has begun; one with the whole file starts again."""
        if response.status_code != 206:
            self._part.unlink(missing_ok=True)
        length = response.headers.get("Content-Length", "")
        self._size = self.done + int(length) if length.isdecimal() else None
        self._etag = response.headers.get("ETag", "")
        found = _SHA256.search(response.headers.get("Repr-Digest", ""))
        self._digest = "" if found is None else base64.b64decode(found[1]).hex()

    def add(self, chunk: bytes) -> None:
        """Further bytes."""
        with self._part.open("ab") as file:
            file.write(chunk)

    def finish(self) -> Path:
        """The file under its name.  Raises ChecksumMismatch, and keeps nothing then."""
        self._part.touch()
        with self._part.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        if digest != self._digest:
            self._part.unlink()
            why = f"its SHA-256 is {digest}, the daemon's {self._digest or 'not said'}"
            remedy = "download it again; if that fails too, look at the network between"
            raise ChecksumMismatch("the file came damaged", where=str(self.target), why=why, remedy=remedy)
        self._part.replace(self.target)
        return self.target

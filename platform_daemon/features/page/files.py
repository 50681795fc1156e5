"""The files of the page: which there are, and each as it is sent."""

from __future__ import annotations

import gzip
import hashlib
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

INDEX = "index.html"
_HERE = Path(__file__).parent
_STATIC = _HERE / "static"
_MEDIA_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
}
# From npm packages, which `make install` puts into node_modules; see package.json.
_VENDOR = {
    f"vendor/{name}": _HERE / "node_modules" / "uplot" / "dist" / name
    for name in ("uPlot.iife.min.js", "uPlot.min.css")
}


@dataclass(frozen=True)
class StaticFile:
    """A file as it is sent: its media type, its bytes, the same compressed by gzip, and its entity tag."""

    media_type: str
    content: bytes
    compressed: bytes
    etag: str


def read_static_file(name: str, port: int, stop_port: int) -> StaticFile | None:
    """The file of that name, "/" between folders; None: there is none, or it is not installed.

    port, stop_port: of this daemon, which the page itself is told; 0: not known.
    """
    path = _paths().get(name)
    if path is None:
        return None
    try:
        modified_ns = path.stat().st_mtime_ns
    except FileNotFoundError:
        return None
    return _read(path, modified_ns, port, stop_port)


@cache
def _paths() -> dict[str, Path]:
    """Every file by its name: a name from outside is looked up here, and never joined to a path."""
    own = {path.relative_to(_STATIC).as_posix(): path for path in _STATIC.rglob("*") if path.suffix in _MEDIA_TYPES}
    return own | _VENDOR


@lru_cache(128)
def _read(path: Path, modified_ns: int, port: int, stop_port: int) -> StaticFile:
    content = path.read_bytes()
    if path.name == INDEX:
        content = content.replace(b"{{port}}", b"%d" % port).replace(b"{{stop_port}}", b"%d" % stop_port)
    compressed = gzip.compress(content, mtime=0)
    etag = f'"{hashlib.sha256(content).hexdigest()[:32]}"'
    return StaticFile(_MEDIA_TYPES[path.suffix], content, compressed, etag)

"""A file without content, which says by being there; a full disk takes it all the same."""

from __future__ import annotations

import contextlib
from pathlib import Path

from .durable import storage_error, sync


class Mark:
    """At `path`."""

    def __init__(self, path: Path) -> None:
        self._path = path

    @property
    def stands(self) -> bool:
        """It was left, and nobody has forgotten it."""
        with contextlib.suppress(OSError):
            return self._path.exists()
        return False

    def leave(self) -> None:
        """On the disk when this returns.  Raises StorageError."""
        try:
            self._path.touch()
            sync(self._path.parent)
        except OSError as error:
            raise storage_error(self._path, error) from error

    def forget(self) -> None:
        """A disk that refuses leaves it where it is."""
        with contextlib.suppress(OSError):
            self._path.unlink(missing_ok=True)

"""A flag that outlives the process: a file without content, which a full disk still takes."""

from __future__ import annotations

import contextlib
from pathlib import Path

from .durable import storage_error, sync


class FlagFile:
    """The flag at `path`: set if that file exists.

    Example:
        >>> flag = FlagFile(data / "stop-asked")
        >>> flag.set()
        >>> flag.is_set
        True
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    @property
    def is_set(self) -> bool:
        """Whether the flag is set; False also where the disk does not answer."""
        with contextlib.suppress(OSError):
            return self._path.exists()
        return False

    def set(self) -> None:
        """Set the flag, on the disk when this returns.  Raises StorageError."""
        try:
            self._path.touch()
            sync(self._path.parent)
        except OSError as error:
            raise storage_error(self._path, error) from error

    def clear(self) -> None:
        """Clear the flag; where the disk refuses it stays set."""
        with contextlib.suppress(OSError):
            self._path.unlink(missing_ok=True)

"""Files NAME@VERSION...: each version is written once, whole or not at all, and is never overwritten."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from .durable import storage_error, write_new_file


@dataclass(frozen=True)
class Version:
    """One version: its name, its number from 1, and its file."""

    name: str
    number: int
    path: Path


@dataclass(frozen=True)
class VersionedFolder:
    """The versions in a folder, which need not exist before the first is added.

    Attributes:
        folder: where they are.
        ending: regular expression of what follows NAME@VERSION in their files' names; other files are left alone.
    """

    folder: Path
    ending: str

    def add(self, name: str, ending: str, content: Callable[[int, str], bytes]) -> Version:
        """Add the next version of `name`, also if another process adds one at the same time.

        content: makes the bytes of the file from the version's number and the stem of the file's name.  Raises
        StorageError, and what `content` raises.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise storage_error(self.folder, error) from error
        while True:
            number = 1 + max((v.number for v in self.versions(name)), default=0)
            path = self.folder / f"{name}@{number}{ending}"
            if write_new_file(path, content(number, path.stem)):
                return Version(name, number, path)

    def versions(self, name: str | None = None) -> list[Version]:
        """All of them, or those of one name; by name and number."""
        pattern = re.compile(rf"([A-Za-z0-9][A-Za-z0-9_-]*)@([1-9]\d{{0,8}}){self.ending}")
        files = sorted(self.folder.iterdir()) if self.folder.is_dir() else []
        found = [Version(m[1], int(m[2]), path) for path in files if (m := pattern.fullmatch(path.name))]
        return sorted((v for v in found if name in (None, v.name)), key=lambda v: (v.name, v.number))

"""Result files of the command line: never overwritten without --force, whole or not at all."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.errors import InputError

if TYPE_CHECKING:
    from platform_daemon.core.schemas.base import Root, Schema


def must_not_exist(path: Path | None, force: bool, *endings: str) -> None:
    """Check that a result file can be written.

    Raises InputError if the file exists, unless `force`; if its folder does not; if its ending is another one; and for
    `-`, by which other programs mean standard output.
    """
    if path is None:
        return
    if str(path) == "-":
        raise InputError("is no file, and results do not go to standard output", where="-", remedy="name a file")
    if path.is_dir():
        raise InputError("is a directory", where=str(path), remedy="name a file")
    if endings and path.suffix and path.suffix.lower() not in endings:
        what = f"{path.suffix} is not what is written there"
        raise InputError(what, where=str(path), remedy=f"let its name end in {' or '.join(endings)}")
    if path.exists() and not force:
        raise InputError("exists already", where=str(path), remedy="choose another name, or overwrite it with --force")
    if not path.absolute().parent.is_dir():
        raise InputError("its folder does not exist", where=str(path), remedy="create the folder")
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        remedy = "name a file in another folder, or change the rights of this one"
        raise InputError("its folder cannot be written", where=str(path), remedy=remedy)


def write_json(path: Path | None, content: Schema | Root[Any] | None) -> None:
    """Write a result as JSON (never NaN) if there is one and a path is given.  Raises StorageError."""
    if path is not None and content is not None:
        from platform_daemon.core.schemas.base import to_json
        from platform_daemon.core.state.durable import write_file  # here, because HDF5 is loaded with it

        write_file(path, to_json(content, indent=1).encode())


def write_page(path: Path, content: bytes) -> None:
    """Write a page.  Raises StorageError."""
    from platform_daemon.core.state.durable import write_file

    write_file(path, content)


def say_note(path: Path, note: str) -> None:
    """What a reader must know of a file, on standard error; nothing for an empty text."""
    if note:
        print(f"note: {path}: {note}", file=sys.stderr)

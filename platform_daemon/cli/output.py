"""Result files of the command line: never overwritten without --force, whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.errors import InputError

if TYPE_CHECKING:
    from platform_daemon.diagnosis import Diagnosis
    from platform_daemon.schemas import DiagnosisReport, Root, Schema


def must_not_exist(path: Path | None, force: bool, *endings: str) -> None:
    """Raises InputError if the file exists, unless `force`; if its folder does not; if it ends like another kind; or if
    it is called `-`, which elsewhere stands for standard output."""
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


def write_json(path: Path | None, content: Schema | Root[Any] | None) -> None:
    """Write a result as JSON (never NaN) if there is one and a path is given.  Raises StorageError."""
    if path is not None and content is not None:
        from platform_daemon.schemas import to_json
        from platform_daemon.store import write_file  # here, because HDF5 is loaded with it

        write_file(path, to_json(content, indent=1).encode())


def write_page(path: Path | None, found: Diagnosis, report: DiagnosisReport) -> None:
    """Write and print its name; without a path, nothing."""
    if path is not None:
        from platform_daemon.diagnosis import compare_residuals
        from platform_daemon.reports import diagnosis_html

        keep_page(path, diagnosis_html(report, compare_residuals(found)))


def keep_page(path: Path, content: bytes) -> None:
    """Write a page that is made and print its name.  Raises StorageError."""
    from platform_daemon.store import write_file

    write_file(path, content)
    print(path)

"""Finished files on disk, one JSON line each: what a crash leaves is whole, and the next run can go on from it."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any

from drivers.errors import InputError
from platform_daemon import __version__

from ..model_registry.adopted_model import AdoptedModel
from .part import FitSettings

_HEAD = b'{"path": "'


class Ledger:
    """Appends finished files; knows those finished before.

    A line holds `path` (absolute), `input` (size and time stamp of the file that was read), `settings` (a digest) and
    `report`, or `error` where the file could not be fitted; such files are tried again.
    """

    def __init__(self, path: Path, settings: FitSettings, *, resume: bool) -> None:
        """Open for appending; a line that was cut off is removed.

        Raises InputError if it holds something else or another run writes it, OSError.
        """
        self._settings = _digest(settings)
        self._file = path.open("a+b")
        try:
            _lock(self._file.fileno(), path)
            self._finished = self._read(path) if resume else {}
            if not resume:
                self._file.truncate(0)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Ledger:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def finished(self, path: Path) -> dict[str, Any] | None:
        """The report of this very file under the same settings, if it is there."""
        line = self._finished.get(str(path.absolute()))
        if line is None or line["settings"] != self._settings or line["input"] != _state(path):
            return None
        return {**line["report"], "file": str(path)}

    def add(self, path: Path, result: dict[str, Any]) -> None:
        """Keep {"report": ...} or {"error": ...} of a file; it is on disk when this returns.  Raises OSError."""
        line = {"path": str(path.absolute()), "input": _state(path), "settings": self._settings, **result}
        self._file.write(json.dumps(line, allow_nan=False).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def _read(self, path: Path) -> dict[str, dict[str, Any]]:
        """Lines with a report by path, the last one counts; a last line that was cut off is removed."""
        self._file.seek(0)
        *lines, tail = self._file.read().split(b"\n")
        entries = [_parsed(line) for line in lines]
        if None in entries or not tail.startswith(_HEAD[: len(tail)]):
            number = entries.index(None) + 1 if None in entries else len(lines) + 1
            remedy = "name another file, or start anew without --resume"
            raise InputError(f"line {number} is not a result of fit", where=str(path), remedy=remedy)
        self._file.truncate(sum(len(line) + 1 for line in lines))
        return {entry["path"]: entry for entry in entries if entry is not None and "report" in entry}


def _parsed(line: bytes) -> dict[str, Any] | None:
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    return entry if isinstance(entry, dict) and {"path", "input", "settings"} <= set(entry) else None


def _lock(descriptor: int, path: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        remedy = "wait for it, or name another file"
        raise InputError("another run writes this file", where=str(path), remedy=remedy) from None


def _state(path: Path) -> dict[str, int] | None:
    """What tells that a file has changed; None if it is not there."""
    try:
        found = path.stat()
    except OSError:
        return None
    return {"size_bytes": found.st_size, "modified_ns": found.st_mtime_ns}


def _digest(settings: FitSettings) -> str:
    """Of everything that a result depends on beside the file."""
    fixed, hints = (sorted((values or {}).items()) for values in (settings.fixed, settings.hold_if_inseparable))
    variant = settings.variant
    named = f"{variant.label} {variant.digest}" if isinstance(variant, AdoptedModel) else variant
    text = [__version__, named, settings.window, fixed, settings.derived, hints, settings.terms, settings.frames]
    digest = hashlib.sha256(json.dumps(text).encode())
    if settings.calibration is not None:
        c = settings.calibration[0]
        digest.update(json.dumps([c.identifier, c.date, c.lna_gain, c.relative_std]).encode())
        for array in (c.sensitivity, c.frequency_hz, c.frequency_response, c.sensitivity_std, c.p_std):
            digest.update(b"-" if array is None else array.tobytes())
    return digest.hexdigest()

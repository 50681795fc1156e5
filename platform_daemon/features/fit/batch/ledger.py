"""Finished files on disk, one JSON line each: what a crash leaves is whole, and the next run can continue from it."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from pathlib import Path
from types import TracebackType

from pydantic import ValidationError

from drivers.errors import InputError, PlatformError
from platform_daemon import __version__
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.control_characters import encodable
from platform_daemon.core.schemas.fits import ErrorSummary, FileState, FitReport, LedgerLine
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.models.adopted_model import AdoptedModel

_HEAD = b'{"path": "'


class Ledger:
    """Appends finished files, a LedgerLine each; knows those finished before."""

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

    def finished(self, path: Path) -> FitReport | None:
        """The report of this very file under the same settings, if it is there."""
        line = self._finished.get(encodable(str(path.absolute())))
        if line is None or line.report is None or line.settings != self._settings or line.input != _state(path):
            return None
        return line.report.model_copy(update={"file": str(path)})

    def add(self, path: Path, outcome: FitReport | PlatformError) -> None:
        """Keep what came of a file; it is on disk when this returns.  Raises OSError."""
        line = LedgerLine(
            path=str(path.absolute()),
            input=_state(path),
            settings=self._settings,
            report=outcome if isinstance(outcome, FitReport) else None,
            error=error_summary(outcome) if isinstance(outcome, PlatformError) else None,
        )
        self._file.write(to_json(line).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def _read(self, path: Path) -> dict[str, LedgerLine]:
        """Lines with a report by path, the last one counts; a last line that was cut off is removed."""
        self._file.seek(0)
        *lines, tail = self._file.read().split(b"\n")
        entries = []
        for number, line in enumerate(lines, start=1):
            try:
                entries.append(LedgerLine.model_validate_json(line))
            except ValidationError:
                raise _foreign(path, number) from None
        if not tail.startswith(_HEAD[: len(tail)]):
            raise _foreign(path, len(lines) + 1)
        self._file.truncate(sum(len(line) + 1 for line in lines))
        return {entry.path: entry for entry in entries if entry.report is not None}


def error_summary(error: PlatformError) -> ErrorSummary:
    """An error among results."""
    return ErrorSummary(title=error.title, detail=str(error))


def _foreign(path: Path, number: int) -> InputError:
    remedy = "name another file, or start again without --resume"
    return InputError(f"line {number} is not a result of fit", where=str(path), remedy=remedy)


def _lock(descriptor: int, path: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        remedy = "wait for it, or name another file"
        raise InputError("another run writes this file", where=str(path), remedy=remedy) from None


def _state(path: Path) -> FileState | None:
    """What tells that a file has changed; None if it is not there."""
    try:
        found = path.stat()
    except OSError:
        return None
    return FileState(size_bytes=found.st_size, modified_ns=found.st_mtime_ns)


def _digest(settings: FitSettings) -> str:
    """Digest of everything that a result depends on, except the file."""
    fixed, hints = (sorted((values or {}).items()) for values in (settings.fixed, settings.hold_if_inseparable))
    model = settings.model
    named = f"{model.label} {model.digest}" if isinstance(model, AdoptedModel) else model
    text = [__version__, named, settings.window, fixed, settings.derived, hints, settings.terms, settings.frames]
    text.append(settings.step)
    digest = hashlib.sha256(json.dumps(text).encode())
    if settings.calibration is not None:
        c = settings.calibration[0]
        digest.update(json.dumps([c.identifier, c.date, c.lna_gain, c.relative_std]).encode())
        for array in (c.sensitivity, c.frequency_hz, c.frequency_response, c.sensitivity_std, c.p_std):
            digest.update(b"-" if array is None else array.tobytes())
    return digest.hexdigest()

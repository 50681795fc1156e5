"""Adopted models on disk: one file per version, written whole, never overwritten; retiring adds a file beside it."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from drivers.errors import InputError
from platform_daemon.estimation import MODELS

from .adopted_model import AdoptedModel, from_json

_NAME = re.compile(r"[a-z][a-z0-9_-]{0,63}")
_FILE = re.compile(r"([a-z][a-z0-9_-]{0,63})@([1-9][0-9]{0,8})\.json")


class UnknownModel(InputError):
    """No adopted model has that name or version."""

    title = "Unknown model"


class Library:
    """The adopted models in a folder; it need not exist before the first is added."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def add(self, model: AdoptedModel) -> AdoptedModel:
        """Keep a model as the next version of its name.  Raises InputError for a bad name, OSError."""
        check_name(model.name)
        self.folder.mkdir(parents=True, exist_ok=True)
        while True:
            version = 1 + max(self._versions(model.name), default=0)
            numbered = replace(model, version=version)
            if _write_new(self.folder / f"{numbered.label}.json", numbered.as_json()):
                return numbered

    def get(self, text: str) -> AdoptedModel:
        """NAME@VERSION, retired or not; or NAME: its newest version that is not retired.

        Raises UnknownModel, InputError for a file that is none of ours.
        """
        name, at, number = text.partition("@")
        if at:
            path = self.folder / f"{text}.json"
            if not _FILE.fullmatch(path.name) or not path.is_file():
                raise self._unknown(text, "there is no such version")
            return self._read(name, int(number))
        for version in sorted(self._versions(name), reverse=True):
            found = self._read(name, version)
            if found.retired is None:
                return found
        raise self._unknown(text, "all its versions are retired" if self._versions(name) else "")

    def all(self) -> list[AdoptedModel]:
        """Every version of every model, by name and version.  Raises InputError for a file that is none of ours."""
        files = (_FILE.fullmatch(p.name) for p in self.folder.glob("*.json")) if self.folder.is_dir() else ()
        return [self._read(n, v) for n, v in sorted((m[1], int(m[2])) for m in files if m)]

    def retire(self, text: str, by: str, reason: str) -> AdoptedModel:
        """Take NAME@VERSION out of use: NAME alone no longer means it.  Raises UnknownModel, InputError."""
        if "@" not in text:
            raise InputError(
                "names no version", where=text, remedy="write NAME@VERSION: versions are retired one by one"
            )
        found = self.get(text)
        said = {"at": datetime.now(UTC).isoformat(timespec="seconds"), "by": by, "reason": reason}
        if not _write_new(self.folder / f"{found.label}.retired", said):
            raise InputError("is retired already", where=found.label, remedy="nothing is to be done")
        return replace(found, retired=said)

    def _versions(self, name: str) -> list[int]:
        files = (_FILE.fullmatch(p.name) for p in self.folder.glob(f"{name}@*.json")) if _NAME.fullmatch(name) else ()
        return [int(m[2]) for m in files if m and m[1] == name]

    def _read(self, name: str, version: int) -> AdoptedModel:
        path = self.folder / f"{name}@{version}.json"
        try:
            found = from_json(json.loads(path.read_text(encoding="utf-8")))
            if (found.name, found.version) != (name, version):
                raise ValueError(f"it holds {found.label}")
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            remedy = "restore the file from a copy, or adopt the model again"
            raise InputError("is no adopted model", where=str(path), why=str(error), remedy=remedy) from None
        retired = path.with_suffix(".retired")
        return replace(found, retired=json.loads(retired.read_text()) if retired.is_file() else None)

    def _unknown(self, text: str, why: str) -> UnknownModel:
        names = ", ".join(m.label for m in self.all()) or "none yet"
        return UnknownModel(f"no adopted model {text!r}", where="models", why=why, remedy=f"adopted are: {names}")


def check_name(name: str) -> None:
    """Raises InputError for a name that cannot be told from others, or is taken by a declared model."""
    if not _NAME.fullmatch(name):
        remedy = "small letters, digits, _ and -, a letter first, at most 64"
        raise InputError(f"{name!r} cannot name a model", where="name", remedy=remedy)
    if name in MODELS:
        raise InputError(f"{name!r} is a declared model", where="name", remedy="choose another name")


def _write_new(path: Path, content: Any) -> bool:
    """Make a file appear whole, on the disk when this returns; False if it is there already.  Raises OSError."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("w", encoding="utf-8") as file:
            json.dump(content, file, indent=1, allow_nan=False)
            file.flush()
            os.fsync(file.fileno())
        os.link(part, path)  # unlike a rename it never replaces
    except FileExistsError:
        return False
    finally:
        part.unlink(missing_ok=True)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
    return True

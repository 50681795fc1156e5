"""Adopted models on disk: one file per version, written whole, never overwritten; retiring adds a second file."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import InputError
from drivers.text_files import read_text_file
from drivers.validation import Model, validated
from platform_daemon.core.recordings.index import Broken
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.model_names import DECLARED_MODELS
from platform_daemon.core.state.durable import write_new_file
from platform_daemon.core.state.versioned import Version, VersionedFolder

from .schema import AdoptedModelRecord, Retirement

if TYPE_CHECKING:
    from .adopted_model import AdoptedModel

_NAME = re.compile(r"[a-z][a-z0-9_-]{0,63}")


class UnknownModel(InputError):
    """No adopted model has that name or version."""

    title = "Unknown model"
    http_status = 404


class Library:
    """The adopted models in a folder; it need not exist before the first is added."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._files = VersionedFolder(folder, r"\.json")

    def add(self, model: AdoptedModel) -> AdoptedModel:
        """Keep a model as the next version of its name.  Raises InputError for a bad name, StorageError."""
        check_name(model.name)

        def content(version: int, label: str) -> bytes:
            return to_json(replace(model, version=version).record(), indent=1).encode()

        return replace(model, version=self._files.add(model.name, ".json", content).number)

    def get(self, text: str) -> AdoptedModel:
        """NAME@VERSION, retired or not; or NAME: its newest version that is not retired.

        Raises UnknownModel, InputError for a file that is not an adopted model.
        """
        name, at, number = text.partition("@")
        versions = self._files.versions(name)
        if at:
            for version in versions:
                if str(version.number) == number:
                    return _read(version)
            raise self._unknown(text, "there is no such version")
        for found in map(_read, reversed(versions)):
            if found.retired is None:
                return found
        raise self._unknown(text, "all its versions are retired" if versions else "")

    def all(self) -> tuple[list[AdoptedModel], list[Broken]]:
        """Every version of every model, by name and version, and the files that hold none."""
        models, broken = [], []
        for version in self._files.versions():
            try:
                models.append(_read(version))
            except InputError as error:
                broken.append(Broken(version.path.stem, version.path, error))
        return models, broken

    def retire(self, text: str, by: str, reason: str) -> AdoptedModel:
        """Take NAME@VERSION out of use: NAME alone no longer means it.  Raises UnknownModel, InputError."""
        if "@" not in text:
            raise InputError(
                "names no version", where=text, remedy="write NAME@VERSION: versions are retired one by one"
            )
        found = self.get(text)
        now = datetime.now(UTC).isoformat(timespec="seconds")
        said = Retirement(at=now, by=by, reason=reason)
        if not write_new_file(self.folder / f"{found.label}.retired", to_json(said, indent=1).encode()):
            raise InputError("is retired already", where=found.label, remedy="nothing is to be done")
        return replace(found, retired=said)

    def _unknown(self, text: str, why: str) -> UnknownModel:
        names = ", ".join(v.path.stem for v in self._files.versions()) or "none yet"
        return UnknownModel(f"no adopted model {text!r}", where="models", why=why, remedy=f"adopted are: {names}")


def check_name(name: str) -> None:
    """Raises InputError for a name that can be confused with others, or is that of a declared model."""
    if not _NAME.fullmatch(name):
        remedy = "small letters, digits, _ and -, a letter first, at most 64"
        raise InputError(f"{name!r} cannot name a model", where="name", remedy=remedy)
    if name in DECLARED_MODELS:
        raise InputError(f"{name!r} is a declared model", where="name", remedy="choose another name")


def _read(version: Version) -> AdoptedModel:
    from .adopted_model import from_record

    try:
        found = from_record(_parsed(AdoptedModelRecord, version.path))
        if (found.name, found.version) != (version.name, version.number):
            raise ValueError(f"it holds {found.label}")
        retired = version.path.with_suffix(".retired")
        return replace(found, retired=_parsed(Retirement, retired) if retired.is_file() else None)
    except (OSError, ValueError, KeyError, RecursionError, InputError) as error:
        why = error.what if isinstance(error, InputError) else str(error)
        remedy = "restore the file from a copy, or adopt the model again"
        raise InputError("is no adopted model", where=str(version.path), why=why, remedy=remedy) from None


def _parsed(model: type[Model], path: Path) -> Model:
    return validated(model, json.loads(read_text_file(path)), path.name)

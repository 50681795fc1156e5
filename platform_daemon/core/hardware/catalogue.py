"""Resonators and sequences by name: those that ship, those of a lab's own folder, and those that were added."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from pydantic import BaseModel

from drivers.errors import ConfigError, InputError
from drivers.specimen import Specimen
from drivers.validation import validated
from platform_daemon.core.recordings.index import Broken
from platform_daemon.core.schemas.requests import SHIPPED_PRESET, TUNED_PRESET, SequencePatch
from platform_daemon.core.settings import locate, read_toml, shipped
from platform_daemon.core.state.versioned import Version, VersionedFolder

ContentT = TypeVar("ContentT", bound=BaseModel)


@dataclass(frozen=True)
class Shelf(Generic[ContentT]):
    """TOML files of one kind.

    Attributes:
        kind: resonators or sequences; model: what a file holds.
        given: a folder of files, NAME.toml, None: none.
        added: where NAME@VERSION.toml are kept, None: nothing can be added.
    """

    kind: str
    model: type[ContentT]
    given: Path | None = None
    added: Path | None = None

    def files(self) -> dict[str, Path]:
        """Every file by its name; NAME of what was added is the newest version."""
        found = dict(self._fixed())
        for version in [] if self.added is None else VersionedFolder(self.added, r"\.toml").versions():
            found[version.name] = found[version.path.stem] = version.path
        return found

    def _fixed(self) -> dict[str, Path]:
        given = {} if self.given is None else {path.stem: path for path in sorted(self.given.glob("*.toml"))}
        return shipped(self.kind) | given

    def path(self, name: str) -> Path:
        """The file of what has this name.  Raises InputError."""
        files = self.files()
        if name not in files:
            what, remedy = f"no {self.kind[:-1]} is called {name!r}", f"one of: {', '.join(files)}"
            raise InputError(what, where=self.kind[:-1], remedy=remedy)
        return files[name]

    def named(self, name: str) -> ContentT:
        """What has this name.  Raises InputError."""
        return self._read(self.path(name))[0]

    def all(self) -> dict[str, ContentT | Broken]:
        """Everything by name, also what cannot be used; what is deleted meanwhile is left out."""
        found: dict[str, ContentT | Broken] = {}
        for name, path in self.files().items():
            try:
                found[name] = self._read(path)[0]
            except ConfigError as error:
                if path.exists():
                    found[name] = Broken(name, path, error)
        return found

    def load(self, name: str) -> tuple[ContentT, str]:
        """The entry of this name, or of the file at this path; and its text.  Raises ConfigError."""
        return self._read(self.files().get(name) or locate(self.kind, name))

    def _read(self, path: Path) -> tuple[ContentT, str]:
        tables, text = read_toml(path)
        return validated(self.model, tables, str(path)), text

    def add(self, name: str, content: ContentT, *, in_its_place: bool = False) -> Version:
        """Keep a new version; in_its_place: also of what ships, which it then stands for.

        Raises InputError for a name that is taken, StorageError.
        """
        if self.kind == "sequences" and name in (SHIPPED_PRESET, TUNED_PRESET):
            why = "as `preset` of an acquisition it means the resonator's own"
            raise InputError(f"{name!r} cannot be added", where="name", why=why, remedy="choose another name")
        if self.added is None or (name in self._fixed() and not in_its_place):
            why = "nothing can be added here" if self.added is None else "it ships, or is in the folder of the lab"
            raise InputError(f"{name!r} cannot be added", where="name", why=why, remedy="choose another name")
        when = datetime.now(UTC).isoformat(timespec="seconds")

        def text(number: int, label: str) -> bytes:
            return f"# {label}, added {when}\n{to_toml(content.model_dump(exclude_none=True))}".encode()

        return VersionedFolder(self.added, r"\.toml").add(name, ".toml", text)


@dataclass(frozen=True)
class Damping:
    """Viscous damping, 1/s, and torque of dry friction over moment of inertia, rad/s^2, as measured."""

    lambda_per_s: float
    tf_over_i_rad_per_s2: float


@dataclass(frozen=True)
class KeptPreset:
    """What tune has kept for a resonator.

    Attributes:
        keys: those that replace keys of the shipped sequence; none where there is no preset that can be used.
        label: NAME@VERSION; job, date: of the tune that found it, ISO 8601.  None: there is none.
        stale: why a kept preset is not used; None: it is used, or there is none.
        damping: what the tune has found of it; None: there is no preset that can be used.
    """

    keys: SequencePatch = field(default_factory=SequencePatch)
    label: str | None = None
    job: str | None = None
    date: str | None = None
    stale: str | None = None
    damping: Damping | None = None


class TunedSequences(Protocol):
    """Sequences that tuning has found, one for each resonator."""

    @property
    def folder(self) -> Path | None:
        """Where they are kept; None: nothing is kept."""

    def preset_of(self, resonator: str, specimen: Specimen) -> KeptPreset:
        """The newest preset of a resonator.  Raises ConfigError for a file that is damaged."""


class NothingTuned:
    """See TunedSequences."""

    folder = None

    def preset_of(self, resonator: str, specimen: Specimen) -> KeptPreset:
        """See TunedSequences."""
        return KeptPreset()


@dataclass(frozen=True)
class Catalogue:
    """What can be measured, and how."""

    resonators: Shelf[Specimen] = Shelf("resonators", Specimen)
    sequences: Shelf[SequencePatch] = Shelf("sequences", SequencePatch)
    tuned: TunedSequences = NothingTuned()  # noqa: RUF009 without state


def open_catalogue(
    added_resonators: Path,
    added_sequences: Path,
    given: Path | None = None,
    tuned: TunedSequences = NothingTuned(),  # noqa: B008 without state
) -> Catalogue:
    """The catalogue of a daemon, with the presets that tune has found.

    Raises ConfigError for a file of `given` that is no resonator or hides a shipped one, or if there is no such folder.
    """
    shelf = Shelf("resonators", Specimen, given, added_resonators)
    if given is not None:
        if not given.is_dir():
            raise ConfigError("is no folder", where=str(given), remedy="name a folder of resonator files")
        for path in sorted(given.glob("*.toml")):
            if path.stem in shipped("resonators"):
                raise ConfigError("a resonator of that name ships", where=str(path), remedy="rename the file")
            shelf.load(path.stem)
    return Catalogue(shelf, Shelf("sequences", SequencePatch, None, added_sequences), tuned)


_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def to_toml(tables: dict[str, Any]) -> str:
    """TOML of keys and of tables; a table inside of a table is written inline."""
    keys = [f"{_key(key)} = {_value(value)}" for key, value in tables.items() if not isinstance(value, dict)]
    inner = [
        "\n".join([f"\n[{_key(name)}]", *(f"{_key(key)} = {_value(value)}" for key, value in table.items())])
        for name, table in tables.items()
        if isinstance(table, dict)
    ]
    return "\n".join([*keys, *inner]).rstrip() + "\n"


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {_value(each)}' for key, each in value.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, date):
        return value.isoformat()
    # TOML takes the numbers and texts of JSON; only DEL must be escaped besides.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")

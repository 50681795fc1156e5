"""Old recordings that the rules allow to remove, and their removal: into an archive, or deletion.

Nothing goes by itself: a person asks, sees what would go, and asks again.
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Collection, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.state.durable import publish
from platform_daemon.core.state.errors import StorageError

from .recording_index import open_index
from .staging import staging_folders, target_of

_TEXTS = (".json", ".toml")


@dataclass(frozen=True)
class RetentionRules:
    """older_than_days: only those that began before; keep_newest: so many of every specimen stay; keep_tags: those with
    one of them stay; keep: ids that stay."""

    older_than_days: float
    keep_newest: int = 0
    keep_tags: frozenset[str] = frozenset({"keep"})
    keep: frozenset[str] = frozenset()


@dataclass(frozen=True)
class OldRecording:
    """A recording that may be removed."""

    file: str
    size: int
    begun: str
    specimen: str


def old_recordings(folder: Path, rules: RetentionRules, now: datetime) -> list[OldRecording]:
    """Recordings that may be removed, oldest first, by the index; unreadable files and resumed series stay.

    Raises StorageError.
    """
    before = (now.astimezone(UTC) - timedelta(days=rules.older_than_days)).isoformat()
    with closing(open_index(folder)) as index:
        known = index.files()
    grow = {target_of(each).name for each in staging_folders(folder)}
    newer, found = Counter[str](), []
    for file, size, begun, specimen, tags in reversed(known):
        newer[specimen] += 1
        stays = newer[specimen] <= rules.keep_newest or tags & rules.keep_tags or Path(file).stem in rules.keep
        if begun < before and not stays and file not in grow:
            found.append(OldRecording(file, size, begun, specimen))
    return found[::-1]


def named_in(folder: Path, identifiers: Collection[str]) -> frozenset[str]:
    """Those of the ids that a file of this folder names: what an adopted model, say, was made from."""
    files = [path for path in sorted(folder.iterdir()) if path.suffix in _TEXTS] if folder.is_dir() else []
    texts = [path.read_text(errors="replace") for path in files]
    return frozenset(each for each in identifiers if any(each in text for text in texts))


def move_away(folder: Path, old: Sequence[OldRecording], archive: Path) -> None:
    """Into the archive, each whole or not at all.  Raises InputError if one is there already, StorageError."""
    for each in old:
        if (archive / each.file).exists():
            remedy = "name another archive, or look at the file that is there"
            raise InputError(
                "a recording of that name is in the archive", where=str(archive / each.file), remedy=remedy
            )
    for each in old:
        part = archive / f".{each.file}.part"
        try:
            shutil.copy2(folder / each.file, part)
            publish(part, archive / each.file)
            (folder / each.file).unlink()
        except OSError as error:
            with suppress(OSError):
                part.unlink(missing_ok=True)
            raise _refused(folder / each.file, error) from None


def delete(folder: Path, old: Sequence[OldRecording]) -> None:
    """For good.  Raises StorageError."""
    for each in old:
        try:
            (folder / each.file).unlink(missing_ok=True)
        except OSError as error:
            raise _refused(folder / each.file, error) from None


def _refused(path: Path, error: OSError) -> StorageError:
    remedy = "mend the disk, then ask again: those before it are gone, it and those after it are where they were"
    return StorageError("the recording cannot be moved", where=str(path), why=error.strerror or "", remedy=remedy)

"""The recordings in a folder.  An id is the file name without its last suffix."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from drivers.errors import PlatformError, RecordingError
from platform_daemon.core.schemas.base import ClockKind
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.state.errors import UnknownRecording

from .reader import open_recording
from .recording import Recording
from .staging import staging_folders, target_of

SUFFIXES = (".h5", ".hdf5", ".mmr")
_CREATED = re.compile(r"\d{8}T\d{6}")


@dataclass(frozen=True)
class Entry:
    """One readable recording; date: ISO 8601, start of the series, or for files from elsewhere the file's own date;
    clock: that the date goes by, None: the file does not say.
    """

    id: str
    path: Path
    size_bytes: int
    frames: int
    variant: str | None
    date: str
    incomplete: str | None
    clock: ClockKind | None = None


@dataclass(frozen=True)
class Broken:
    """A file that looks like what is listed but is not usable, and why."""

    id: str
    path: Path
    error: PlatformError


@dataclass(frozen=True)
class Listing:
    """Everything in the folder, sorted by name; broken files are reported, never hidden.

    last: name of the last file that was looked at, if others come after it.
    """

    recordings: tuple[Entry, ...]
    broken: tuple[Broken, ...]
    last: str | None = None


def list_recordings(
    folder: Path | str,
    *,
    after: str = "",
    limit: int | None = None,
    only: Container[str] | None = None,
    newest: bool = False,
    known: Callable[[Sequence[Path]], Mapping[Path, Entry]] = lambda paths: {},
) -> Listing:
    """The recordings in `folder` (not below it); reads no volts.  A folder that does not exist is empty.

    Files whose name is no text come with the first page.

    Args:
        folder: of the recordings.
        after: only files that come after the one of this name.
        limit: only so many files.
        only: names of files; no other file is opened.
        newest: newest first, by the time in the name; those without one come last.  False: by name.
        known: says what is known of files already; they are not opened.
    """
    entries, broken = [], [] if after or only is not None else _unnamable(Path(folder))
    files = list(recording_files(Path(folder)))
    ids: dict[str, Path] = {}
    for path in files:
        ids.setdefault(path.stem, path)
    wanted = [path for path in files if only is None or path.name in only]
    if newest:
        wanted.sort(key=lambda path: _age(path.name))
        wanted = [path for path in wanted if not after or _age(path.name) > _age(after)]
    else:
        wanted = [path for path in wanted if path.name > after]
    known_entries = known(wanted[:limit])
    for path in wanted[:limit]:
        try:
            if ids[path.stem] != path:
                what, remedy = "another file has the same id", "rename one of them"
                raise RecordingError(what, where=str(path), remedy=remedy)
            entries.append(known_entries.get(path) or entry_of(open_recording(path)))
        except RecordingError as error:
            broken.append(Broken(path.stem, path, error))
        except FileNotFoundError:
            continue  # deleted while we were looking
    more = limit is not None and len(wanted) > limit
    return Listing(tuple(entries), tuple(broken), wanted[limit - 1].name if limit is not None and more else None)


def resolve(folder: Path | str, identifier: str) -> Path:
    """The file of an id.  Raises UnknownRecording.

    Ids are compared with the names in the folder and never become part of a path, so none can lead out of it.  An id
    may have its letters in another form of Unicode than the name of the file (a Mac writes the form that a keyboard
    does not), if only one file is meant.
    """
    names = [name for name in _names(Path(folder)) if _is_text(name)]
    ids = [os.path.splitext(name)[0] for name in names]
    for name, each in zip(names, ids, strict=True):
        if each == identifier:
            return Path(folder, name)
    alike = [name for name, each in zip(names, ids, strict=True) if same_name(each) == same_name(identifier)]
    if len(alike) == 1:
        return Path(folder, alike[0])
    what, why, remedy = f"no recording {identifier!r}", "", "list the recordings for their ids"
    if any(target_of(each).stem == identifier for each in staging_folders(Path(folder))):
        why = "its shots are put together when the series has ended"
        remedy = "wait until then; meanwhile each shot that is on the disk can be read by its frame"
    raise UnknownRecording(what, where=str(folder), why=why, remedy=remedy)


def recording_files(folder: Path) -> Iterator[Path]:
    """What may be a recording by its name and place, sorted by name."""
    for name in _names(folder):
        if _is_text(name):
            yield folder / name


def _names(folder: Path) -> list[str]:
    """Sorted; among thousands of files only links are looked at one by one."""
    if not folder.is_dir():
        return []
    with os.scandir(folder) as entries:
        return sorted(each.name for each in entries if _may_be_recording(each, folder))


def _may_be_recording(entry: os.DirEntry[str], folder: Path) -> bool:
    if entry.name.startswith(".") or os.path.splitext(entry.name)[1] not in SUFFIXES:
        return False
    if not entry.is_symlink():
        return entry.is_file()
    path = folder / entry.name
    return path.is_file() and _stays_in(path, folder)


def _unnamable(folder: Path) -> list[Broken]:
    """Files whose name is no text: nothing that is sent or stored could name them."""
    found = [folder / name for name in _names(folder) if not _is_text(name)]
    shown = [path.with_name(os.fsencode(path.name).decode(errors="backslashreplace")) for path in found]
    return [Broken(path.stem, path, _no_text(path)) for path in shown]


def _no_text(path: Path) -> RecordingError:
    return RecordingError("the name of the file is no text in UTF-8", where=str(path), remedy="rename it")


def _is_text(name: str) -> bool:
    """Linux allows any bytes as a name; Python reads those that are no UTF-8 as halves of characters."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _stays_in(path: Path, folder: Path) -> bool:
    """A link may lead to another name in the folder, and nowhere else: what is served is what lies here."""
    return path.resolve().parent == folder.resolve()


def _age(name: str) -> tuple[int, str]:
    """Smaller for what is newer, by the time in the name; 0: there is none."""
    found = _CREATED.search(name)
    return (0 if found is None else -int(found[0].replace("T", "")), name)


def entry_of(recording: Recording) -> Entry:
    """What a list says of a recording.  Raises FileNotFoundError if its file was deleted meanwhile."""
    path, provenance = recording.path, recording.provenance
    modified = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds")
    return Entry(
        id=path.stem,
        path=path,
        size_bytes=recording.size_bytes,
        frames=recording.frames,
        variant=recording.variant,
        date=provenance.start_time if provenance else modified,
        incomplete=provenance.incomplete if provenance else None,
        clock=provenance.clock if provenance else None,
    )

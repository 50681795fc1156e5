"""Reading HDF5 without ever letting an h5py exception through: each defect becomes one RecordingError.

h5py reports damage by almost any exception type (OSError, KeyError, RuntimeError, ValueError, ...), so the guard around
each library call is broad, and there is nothing but library calls inside it.
"""

from __future__ import annotations

import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

from .errors import NotFinite

MAX_ITEMS = 10_000_000
"""A side table larger than this is damage, not data; reading it would only exhaust the memory."""

MAX_FRAME_BYTES = 8 << 30
ANOTHER_COPY = "use another copy of the file, or record again"


@contextmanager
def open_hdf5(path: Path | str) -> Iterator[Hdf5File]:
    """The file opened for reading.  Raises RecordingError if it is missing, no regular file, unreadable or damaged."""
    path = Path(path)
    _check_file(path)
    try:
        # best-effort: a read-only or network disk that cannot lock must not keep anyone from reading.
        h5 = h5py.File(path, "r", locking="best-effort")
    except Exception as error:
        raise _not_hdf5(path, error) from None
    try:
        yield Hdf5File(path, h5)
    finally:
        with guard(str(path), "a file that closes cleanly"):
            h5.close()


def _check_file(path: Path) -> None:
    try:
        info = path.stat()
        if not stat.S_ISREG(info.st_mode):
            what = "is a directory" if stat.S_ISDIR(info.st_mode) else "is not a regular file"
            raise RecordingError(what, where=str(path), remedy="name an HDF5 recording")
        with path.open("rb"):
            pass
    except FileNotFoundError:
        raise RecordingError("no such file", where=str(path), remedy="check the path") from None
    except PermissionError:
        remedy = "check the permissions of the file and its folder"
        raise RecordingError("no permission to read", where=str(path), remedy=remedy) from None
    except (OSError, ValueError) as error:
        raise RecordingError(f"cannot be opened: {error}", where=str(path), remedy="check the path and disk") from None
    if info.st_size == 0:
        raise RecordingError("the file is empty", where=str(path), why="Expected HDF5", remedy=ANOTHER_COPY)


def _not_hdf5(path: Path, error: Exception) -> RecordingError:
    with path.open("rb") as file:
        signed = file.read(8) == b"\x89HDF\r\n\x1a\n"
    if signed:
        what = "the HDF5 file is truncated or damaged"
        return RecordingError(what, where=str(path), why=_first_line(error), remedy=ANOTHER_COPY)
    remedy = "name a recording (.mmr or .h5); text and NumPy files are not read"
    return RecordingError("not an HDF5 file", where=str(path), why="The HDF5 signature is missing", remedy=remedy)


@contextmanager
def guard(where: str, expected: str) -> Iterator[None]:
    """Turns whatever a library call raises into a RecordingError at `where`.  Wrap library calls only."""
    try:
        yield
    except RecordingError:
        raise
    except Exception as error:
        why = f"Expected {expected}; HDF5 says: {_first_line(error)}"
        raise RecordingError("cannot be read", where=where, why=why, remedy=ANOTHER_COPY) from None


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:200]


class Hdf5File:
    """An open file.  Every method names objects by absolute path and returns None for one that is absent."""

    def __init__(self, path: Path, h5: h5py.File) -> None:
        self.path, self._h5 = path, h5

    @property
    def size_bytes(self) -> int:
        """Size of the file."""
        with guard(str(self.path), "a file"):
            return int(self._h5.id.get_filesize())

    def place(self, name: str) -> str:
        """`file:/path`, for messages."""
        return f"{self.path}:{name}"

    def defect(self, what: str, name: str, expected: str, remedy: str = "correct the file") -> RecordingError:
        """The error to raise for an object that is not as it must be."""
        return RecordingError(what, where=self.place(name), why=f"Expected {expected}", remedy=remedy)

    def names(self, group: str) -> tuple[str, ...]:
        """Names inside a group, without opening what they name; () if the group is absent."""
        item = self._item(group)
        with guard(self.place(group), "a list of names"):
            return tuple(sorted(item)) if isinstance(item, h5py.Group) else ()

    def has_dataset(self, name: str) -> bool:
        """Whether there is anything of this name.  Raises RecordingError."""
        return self._item(name) is not None

    def has_group(self, name: str) -> bool:
        """Whether the group exists.  Raises RecordingError if something else has its name."""
        item = self._item(name)
        if item is not None and not isinstance(item, h5py.Group):
            raise self.defect("not a group", name, "a group")
        return item is not None

    def shape(self, name: str) -> tuple[tuple[int, ...], np.dtype[Any]] | None:
        """Shape and type of a dataset, without reading it."""
        item = self._dataset(name)
        if item is None:
            return None
        with guard(self.place(name), "a dataset"):
            return tuple(item.shape or ()) if item.shape is not None else (0,), item.dtype

    def attribute(self, group: str, name: str) -> Any:
        """A text or number attribute; None if absent or of another kind (attributes are extras, never required)."""
        item = self._item(group)
        with guard(self.place(f"{group}@{name}"), "an attribute"):
            value = None if item is None or name not in item.attrs else item.attrs[name]
        value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        return value if isinstance(value, str | int | float | np.number) else None

    def values(self, name: str) -> NDArray[Any] | None:
        """A numeric dataset of any width, as it is."""
        item = self._dataset(name)
        if item is None:
            return None
        with guard(self.place(name), "numbers"):
            kind, size = item.dtype.kind, item.size
            value = np.asarray(item[()]) if kind in "iufc" and size is not None and size <= MAX_ITEMS else None
        if value is None:
            raise self.defect(f"{size} items of type {item.dtype}", name, f"at most {MAX_ITEMS} numbers")
        return value

    def number(self, name: str, unit: str) -> float | int | None:
        """One finite real number.  Arrays of one element count as a scalar: MATLAB cannot write any other."""
        value = self.values(name)
        if value is None:
            return None
        if value.size != 1 or value.dtype.kind == "c":
            raise self.defect(f"shape {value.shape}, type {value.dtype}", name, f"one real number in {unit}")
        if not np.isfinite(value).all():
            raise self.defect("not finite", name, f"one real number in {unit}")
        return value.reshape(-1)[0].item()

    def texts(self, name: str) -> tuple[str, ...] | None:
        """Strings of any HDF5 kind (variable or fixed length), in file order, without padding."""
        item = self._dataset(name)
        if item is None:
            return None
        with guard(self.place(name), "UTF-8 text"):
            is_text = item.dtype.kind == "S" or h5py.check_string_dtype(item.dtype) is not None
            if not is_text or item.size is None or item.size > MAX_ITEMS:
                raise self.defect(f"type {item.dtype}", name, "text")
            raw = np.asarray(item[()]).reshape(-1)
            decoded = (b.decode("utf-8") if isinstance(b, bytes) else str(b) for b in raw)
            # Fixed-length strings come padded with blanks by some writers; the length of the others is exact.
            return tuple(text.rstrip("\0 ") if item.dtype.kind == "S" else text for text in decoded)

    def text(self, name: str) -> str | None:
        """One string."""
        found = self.texts(name)
        if found is not None and len(found) != 1:
            raise self.defect(f"{len(found)} strings", name, "one string")
        return None if found is None else found[0]

    def frame(self, name: str, k: int, shape: tuple[int, int, int]) -> NDArray[np.float64]:
        """Frame `k` of a (frame, channel, sample) dataset: (channel, sample) float64, all finite."""
        found = self.shape(name)
        if found is None or found[0] != shape:
            raise self.defect("changed since the file was opened", name, f"shape {shape}", "open the file again")
        if shape[1] * shape[2] * 8 > MAX_FRAME_BYTES:
            raise self.defect(f"one frame has {shape[1:]} samples", name, f"at most {MAX_FRAME_BYTES >> 30} GiB")
        item = self._dataset(name)
        with guard(self.place(f"{name}[frame {k}]"), "volts"):
            volts = np.asarray(item[k], dtype=np.float64)
        if not np.isfinite(volts).all():
            channel, sample = (int(i) for i in np.argwhere(~np.isfinite(volts))[0])
            place = f"{name}[frame {k}, channel {channel}, sample {sample}]"
            raise NotFinite(
                f"not_finite: value is {volts[channel, sample]}",
                where=self.place(place),
                why="Expected finite volts",
                remedy="leave this frame out: choose others (--frames, or `frames` of a request)",
            )
        return volts

    def _dataset(self, name: str) -> Any:
        item = self._item(name)
        if item is not None and not isinstance(item, h5py.Dataset):
            raise self.defect("not a dataset", name, "a dataset")
        return item

    def _item(self, name: str) -> Any:
        with guard(self.place(name), "a readable object"):
            parent: Any = self._h5
            for part in (p for p in name.split("/") if p):
                if not isinstance(parent, h5py.Group) or part not in parent:
                    return None
                parent = parent[part]
            return parent

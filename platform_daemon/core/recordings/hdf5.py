"""Reading HDF5 without ever letting an h5py exception through: each defect becomes one RecordingError.

h5py reports damage by almost any exception type (OSError, KeyError, RuntimeError, ValueError, ...), so the guard around
each library call is broad, and there is nothing but library calls inside it.
"""

from __future__ import annotations

import errno
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.state.errors import (
    NotFinite,
    RecordingInUse,
    RecordingNotNow,
    RecordingUnfinished,
    UnknownUnit,
)

from .other_files import refuse_missing_filters, refuse_other_kind
from .staging import folder_of
from .unit_conversion import Conversion, conversion

MAX_ITEMS = 10_000_000
"""A side table larger than this is damage, not data; reading it would only exhaust the memory."""

MAX_FRAME_BYTES = 8 << 30
_COMPLEX = (("real", "imag"), ("re", "im"), ("r", "i"))
"""Names, in small letters, of the fields in which MATLAB, Octave and others keep complex numbers."""
ANOTHER_COPY = "use another copy of the file, or record again"
_LATER = "try again when that program has closed the file"
_STILL_WRITTEN_S = 30.0
"""A file that ends too early is called damaged only when it has not changed for so long."""


@contextmanager
def open_hdf5(path: Path | str) -> Iterator[Hdf5File]:
    """The file opened for reading.

    Raises RecordingInUse if another program has it open for writing, RecordingUnfinished if it may still be written,
    RecordingError if it is missing, no regular file, unreadable or damaged.
    """
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
        raise _missing(path) from None
    except PermissionError:
        remedy = "check the permissions of the file and its folder"
        raise RecordingNotNow("no permission to read", where=str(path), remedy=remedy) from None
    except (OSError, ValueError) as error:
        raise RecordingNotNow(f"cannot be opened: {error}", where=str(path), remedy="check the path and disk") from None
    if info.st_size == 0:
        if _changes(info.st_mtime):
            raise _unfinished(path, "The file is empty")
        raise RecordingError("the file is empty", where=str(path), why="Expected HDF5", remedy=ANOTHER_COPY)


def _changes(modified_s: float) -> bool:
    """Whether a file was modified moments ago, by a clock that may be that of another computer."""
    return abs(time.time() - modified_s) < _STILL_WRITTEN_S


def _unfinished(path: Path, why: str) -> RecordingUnfinished:
    what, remedy = "the file is still being written, or truncated", "try again in a minute"
    return RecordingUnfinished(what, where=str(path), why=f"{why} and has changed moments ago", remedy=remedy)


def _missing(path: Path) -> RecordingError:
    """No file; of a series that has not been put together, where its shots are."""
    folder = folder_of(path)
    shots = len(list(folder.glob("shot_*.h5"))) if folder.is_dir() else 0
    if not shots:
        beside = path.parent.iterdir() if path.parent.is_dir() else ()
        alike = [each.name for each in beside if same_name(each.name) == same_name(path.name)]
        why = f"There is one that looks like it, with other characters or blanks: {alike[0]!a}" if alike else ""
        return RecordingError("no such file", where=str(path), why=why, remedy="check the path")
    return RecordingError(
        f"not put together yet: {shots} acknowledged shots of it are in {folder.name}",
        where=str(path),
        why="the series is still being measured, or its program was killed, crashed or lost its power",
        remedy="wait for its end; if nothing measures any more, the next `platform-daemon measure` into this folder "
        "puts them together, as the start of a daemon does in its data folder",
    )


def _not_hdf5(path: Path, error: Exception) -> RecordingError:
    said = str(error)
    if isinstance(error, OSError) and error.errno in (errno.EAGAIN, errno.EACCES) and "lock" in said:
        what, why = "another program has the file open for writing", "HDF5 locks a file while it is written"
        return RecordingInUse(what, where=str(path), why=why, remedy=_LATER)
    if "already open for write" in said or "already open for SWMR write" in said:
        what, why = "the file is marked as open for writing", "A program has it open, or ended without closing it"
        remedy = f"{_LATER}; if none has it open, run h5clear -s on the file"
        return RecordingInUse(what, where=str(path), why=why, remedy=remedy)
    if "truncated file" in said and _changes(path.stat().st_mtime):
        return _unfinished(path, "It ends too early")
    with path.open("rb") as file:
        begin = file.read(64)
    refuse_other_kind(begin, path)
    if begin.startswith(b"\x89HDF\r\n\x1a\n"):
        what = "the HDF5 file is truncated or damaged"
        return RecordingError(what, where=str(path), why=_first_line(error), remedy=ANOTHER_COPY)
    remedy = "name a recording (.mmr or .h5); a table needs its own suffix, as .csv or .npz"
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
        self._items: dict[str, Any] = {}

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
        if isinstance(value, np.ndarray) and value.size == 1:  # MATLAB writes no others
            value = value.reshape(-1)[0]
        value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        return value if isinstance(value, str | int | float | np.number) else None

    def units(self, name: str) -> str:
        """What a dataset, or the file ("/"), says its numbers are in; "" where it does not say."""
        item = self._item(name)
        with guard(self.place(f"{name}@units"), "an attribute"):
            found = [key for key in (() if item is None else item.attrs) if key.lower() in ("units", "unit")]
            value = item.attrs[found[0]] if found else ""
        if isinstance(value, np.ndarray) and value.size == 1:
            value = value.reshape(-1)[0]
        if not isinstance(value, str | bytes | int | float | np.number):
            raise self.defect("has units that are no text", name, "text like Hz", "write the units as text")
        raw = value if isinstance(value, bytes) else str(value).encode("utf-8", "surrogateescape")
        try:
            return raw.decode("utf-8").rstrip("\0").strip()
        except UnicodeDecodeError:
            return raw.decode("latin-1").rstrip("\0").strip()

    def conversion(self, name: str, unit: str) -> Conversion:
        """How the numbers of a dataset become numbers in `unit`; a dataset that says no unit has that one.

        Raises UnknownUnit for one that is unknown or of another dimension.
        """
        said = self.units(name)
        found = conversion(said, unit) if said else Conversion()
        if found is None:
            raise UnknownUnit(
                f"has units {said!r}",
                where=self.place(name),
                why=f"Expected {unit}, or a multiple as those with the prefixes n, u, m, k and M",
                remedy=f"convert the numbers to {unit}, or correct the attribute units",
            )
        return found

    def is_packed(self, name: str) -> bool:
        """Whether a dataset holds `(value - add_offset) / scale_factor`, as the CF conventions of netCDF have it."""
        item = self._item(name)
        with guard(self.place(name), "attributes"):
            return item is not None and ("scale_factor" in item.attrs or "add_offset" in item.attrs)

    def values(self, name: str, unit: str = "") -> NDArray[Any] | None:
        """A numeric dataset of any width, unpacked and in `unit`; "": in whatever unit it is.

        Raises RecordingError, UnknownUnit for numbers in a unit that does not convert.
        """
        item = self._dataset(name)
        if item is None:
            return None
        with guard(self.place(name), "a dataset"):
            refuse_missing_filters(item, self.place(name))
        with guard(self.place(name), "numbers"):
            kind, size = item.dtype.kind, item.size
            parts = _parts(item.dtype)
            readable = size is not None and size <= MAX_ITEMS and (kind in "iufc" or parts is not None)
            value = np.asarray(item[()]) if readable else None
            if value is not None and parts is not None:
                value = value[parts[0]] + 1j * value[parts[1]]
        if value is None:
            raise self.defect(f"{size} items of type {item.dtype}", name, f"numbers, at most {MAX_ITEMS}")
        return self._physical(name, value, unit)

    def _physical(self, name: str, raw: NDArray[Any], unit: str) -> NDArray[Any]:
        """Numbers as they are meant: `raw` unpacked, NaN for missing ones, and converted to `unit`."""
        factor, offset = (
            self._packing(name, key, neutral) for key, neutral in (("scale_factor", 1.0), ("add_offset", 0.0))
        )
        missing = [self._packing(name, key, np.nan, finite=False) for key in ("_FillValue", "missing_value")]
        absent = np.isin(raw, [value for value in missing if value == value])
        change = self.conversion(name, unit) if unit else Conversion()
        scale, shift = factor * change.factor, offset * change.factor + change.offset
        if (scale, shift) == (1.0, 0.0) and not absent.any():
            return raw
        with np.errstate(over="ignore", invalid="ignore"):
            found = raw * scale + shift if raw.dtype.kind == "c" else raw.astype(np.float64) * scale + shift
        return np.asarray(np.where(absent, np.nan, found))

    def _packing(self, name: str, key: str, neutral: float, *, finite: bool = True) -> float:
        """A number of the CF conventions, `neutral` if it is absent.  Raises RecordingError."""
        item = self._item(name)
        with guard(self.place(f"{name}@{key}"), "an attribute"):
            there = key in item.attrs
        if not there:
            return neutral
        value = self.attribute(name, key)
        bad = isinstance(value, str | None) or (finite and not np.isfinite(value)) or (value == 0 and neutral == 1)
        if bad:
            raise self.defect(
                f"is {value!r}", f"{name}@{key}", "one number", "correct the attribute, or unpack the data"
            )
        return float(value)

    def number(self, name: str, unit: str) -> float | int | None:
        """One finite real number in `unit`.  Arrays of one element are scalars: MATLAB cannot write any other.

        Raises RecordingError, UnknownUnit.
        """
        value = self.values(name, unit)
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

    def frame(self, name: str, k: int, shape: tuple[int, int, int], unit: str) -> NDArray[np.float64]:
        """Frame `k` of a (frame, channel, sample) dataset: (channel, sample) float64 in `unit`, all finite.

        unit: "" for numbers as they are.  Raises RecordingError, UnknownUnit, NotFinite.
        """
        found = self.shape(name)
        if found is None or found[0] != shape:
            raise self.defect("changed since the file was opened", name, f"shape {shape}", "open the file again")
        if shape[1] * shape[2] * 8 > MAX_FRAME_BYTES:
            raise self.defect(f"one frame has {shape[1:]} samples", name, f"at most {MAX_FRAME_BYTES >> 30} GiB")
        item = self._dataset(name)
        with guard(self.place(name), "a dataset"):
            refuse_missing_filters(item, self.place(name))
        with guard(self.place(f"{name}[frame {k}]"), "volts"):
            raw = np.asarray(item[k])
        volts = np.asarray(self._physical(name, raw, unit), dtype=np.float64)
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
        """The object of this name, None: there is none.  Kept: finding one takes longer than reading most of them."""
        if name not in self._items:
            above, _, last = name.rstrip("/").rpartition("/")
            parent = self._item(above) if above else self._h5
            with guard(self.place(name), "a readable object"):
                there = not last or (isinstance(parent, h5py.Group) and last in parent)
                self._items[name] = (parent[last] if last else parent) if there else None
        return self._items[name]


def _parts(dtype: np.dtype[Any]) -> tuple[str, str] | None:
    """Names of the real and of the imaginary field of a compound type of two floats; None for any other type."""
    by_name = {name.lower(): name for name in dtype.names or () if dtype[name].kind == "f"}
    pairs = [(by_name[re], by_name[im]) for re, im in _COMPLEX if set(by_name) == {re, im}]
    return pairs[0] if pairs and len(dtype.names or ()) == 2 else None

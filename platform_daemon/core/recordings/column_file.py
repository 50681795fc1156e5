"""Tables of time and signal from elsewhere: CSV and the like, and npz.

The names of the columns say what they hold, with the unit in brackets or at the end, as `time_s`, `t [ms]`,
`x_am2_per_s`, `u1 (mV)`, `phi_deg`.  Where they do not, the caller tells it, or a file of the same name with `.toml`
behind it:

    time = "t"
    time_unit = "ms"
    signal = ["a"]
    unit = "deg"
"""

from __future__ import annotations

import csv
import re
import tomllib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from drivers.errors import RecordingError
from drivers.text_files import read_text_file

from .angle_series import AngleSeries
from .array_recording import Quantity, refuse_quantities, signal_of
from .recording import Recording
from .unit_conversion import conversion

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".npz")
_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\])]+)[\])]\s*$")
_ENDINGS = {
    **{"am2_per_s": "A m^2/s", "mam2_per_s": "mA m^2/s", "uam2_per_s": "uA m^2/s", "v": "V", "mv": "mV", "uv": "uV"},
    **{"rad": "rad", "mrad": "mrad", "deg": "deg", "s": "s", "ms": "ms", "us": "us", "ns": "ns"},
}
_QUANTITIES: dict[Quantity, str] = {"dmdt": "A m^2/s", "voltage": "V", "angle": "rad"}


class Columns(BaseModel):
    """Which columns of a table are time and signal, and their units; None: as their names say."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    time: str | None = None
    signal: Annotated[tuple[str, ...], Field(min_length=1)] | None = None
    time_unit: str | None = None
    unit: str | None = None


def is_column_file(path: Path) -> bool:
    """By its name."""
    return path.suffix.lower() in SUFFIXES


def read_columns(path: Path, told: Columns | None = None) -> Recording | AngleSeries:
    """The signal in a table.

    told: which columns; None: as their names or the file next to it say.  Raises RecordingError for a file that is no
    table, a column that is not there or has no unit, and as signal_of.
    """
    columns = told or _told_by_file(path)
    table = _npz(path) if path.suffix.lower() == ".npz" else _text(path)
    time = columns.time or _time_name(table, path)
    names = columns.signal or tuple(name for name in table if name != time)
    missing = [name for name in (time, *names) if name not in table]
    if missing:
        raise RecordingError(
            f"there is no column {missing[0]!r}", where=str(path), remedy=f"one of: {', '.join(map(repr, table))}"
        )
    time_s = table[time] * _factor(columns.time_unit or _unit_in(time), "s", f"{path}: {time}", "time_unit")
    quantity, signal = _signal(table, names, columns.unit, path)
    return signal_of(time_s.reshape(-1), signal, quantity, where=str(path))


def _signal(
    table: Mapping[str, NDArray[np.float64]], names: tuple[str, ...], unit: str | None, path: Path
) -> tuple[Quantity, NDArray[np.float64]]:
    """What the columns are, and their samples in SI, (channels, n)."""
    rows: list[NDArray[np.float64]] = []
    found: dict[Quantity, str] = {}
    for name in names:
        said = unit or _unit_in(name)
        quantity = next((each for each, si in _QUANTITIES.items() if said and conversion(said, si)), None)
        if quantity is None:
            raise _no_unit(name, said, path, "unit", ", ".join((*_QUANTITIES.values(), "deg")))
        found[quantity] = name
        rows.append(np.atleast_2d(table[name]) * _factor(said, _QUANTITIES[quantity], f"{path}: {name}", "unit"))
    if len(found) != 1:
        raise refuse_quantities(list(names), str(path))
    if len({row.shape[1] for row in rows}) > 1:
        raise RecordingError("the columns are not equally long", where=str(path), remedy="give each sample of each")
    return next(iter(found)), np.concatenate(rows)


def _factor(said: str | None, wanted: str, where: str, key: str) -> float:
    change = None if not said else conversion(said, wanted)
    if change is None:
        path, _, name = where.rpartition(": ")
        raise _no_unit(name, said, Path(path), key, wanted)
    return change.factor


def _no_unit(name: str, said: str | None, path: Path, key: str, wanted: str) -> RecordingError:
    what = f"the unit of the column {name!r} is not known" if not said else f"the column {name!r} is in {said!r}"
    remedy = f"call the column `{name} [UNIT]`, or write {path.name}.toml with the line {key} = 'UNIT'"
    return RecordingError(what, where=str(path), why=f"it must be one of {wanted}, or convertible to it", remedy=remedy)


def _unit_in(name: str) -> str | None:
    found = _BRACKETS.match(name)
    if found:
        return found[2]
    lower = name.lower()
    ends = [ending for ending in _ENDINGS if lower.endswith(f"_{ending}") or lower == ending]
    return _ENDINGS[max(ends, key=len)] if ends else None


def _time_name(table: Mapping[str, NDArray[np.float64]], path: Path) -> str:
    """The column whose name begins with t or time, and that is no signal.  Raises RecordingError."""
    for name in table:
        found = _BRACKETS.match(name)
        stem = (found[1] if found else name).strip().lower()
        if stem in ("t", "time") or re.match(r"^(t|time)_[a-z]+$", stem):
            return name
    remedy = f"call it time_s, or write {path.name}.toml with the line time = 'NAME'"
    why = f"the columns are {', '.join(map(repr, table))}"
    raise RecordingError("no column is called time", where=str(path), why=why, remedy=remedy)


def _told_by_file(path: Path) -> Columns:
    beside = path.with_name(f"{path.name}.toml")
    if not beside.is_file():
        return Columns()
    try:
        table = tomllib.loads(read_text_file(beside))
    except (OSError, ValueError) as error:
        raise RecordingError("is no TOML file", where=str(beside), why=str(error), remedy="correct it") from None
    try:
        return Columns.model_validate(table)
    except ValidationError as error:
        first = error.errors()[0]
        where = f"{beside}: {'.'.join(map(str, first['loc']))}"
        remedy = f"the keys are {', '.join(Columns.model_fields)}: names and units are texts, signal is a list of names"
        raise RecordingError(first["msg"], where=where, remedy=remedy) from None


def _npz(path: Path) -> dict[str, NDArray[np.float64]]:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name], dtype=np.float64) for name in arrays.files}
    except (OSError, ValueError, TypeError, zipfile.BadZipFile) as error:
        remedy = "write it by numpy.savez(path, time_s=..., dmdt_am2_per_s=...)"
        raise RecordingError("cannot be read as npz", where=str(path), why=str(error), remedy=remedy) from None


def _text(path: Path) -> dict[str, NDArray[np.float64]]:
    """The columns by name; of a table without names by their numbers from 0."""
    try:
        lines = enumerate(read_text_file(path).splitlines(), start=1)
    except (OSError, ValueError) as error:
        remedy = "name a readable text file in UTF-8"
        raise RecordingError("cannot be read as text", where=str(path), why=str(error), remedy=remedy) from None
    kept = [(number, line.strip()) for number, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if len(kept) < 2:
        raise RecordingError("holds no table", where=str(path), remedy="write a line of names, then a line per sample")
    separator = next((mark for mark in "\t;," if mark in kept[-1][1] or mark in kept[0][1]), None)
    first = _cells(kept[0][1], separator)
    named = not _is_number(first[0].replace(",", "."))
    body = kept[1:] if named else kept
    values = np.array([_numbers(line, separator, len(first), f"{path}: line {number}") for number, line in body])
    names = [cell.strip() for cell in first] if named else [str(k) for k in range(len(first))]
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        what, remedy = f"two columns are called {twice[0]!r}", "give each column a name of its own"
        raise RecordingError(what, where=str(path), remedy=remedy)
    return {name: values[:, k] for k, name in enumerate(names)}


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line, without the quotes that some programs put around them."""
    return line.split() if separator is None else next(csv.reader([line], delimiter=separator))


def _numbers(line: str, separator: str | None, count: int, where: str) -> list[float]:
    """The numbers of a line; a comma is a decimal one where it separates no columns.  Raises RecordingError."""
    cells = _cells(line, separator)
    remedy = f"write {count} numbers in each line, separated alike"
    if len(cells) != count:
        what = f"has {len(cells)} columns, the first line has {count}"
        raise RecordingError(what, where=where, remedy=remedy)
    found = []
    for k, cell in enumerate(cells):
        number = cell.replace(",", ".") if separator in ("\t", ";") else cell
        if not _is_number(number):
            raise RecordingError(f"{cell!r} in column {k + 1} is no number", where=where, remedy=remedy)
        found.append(float(number))
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True

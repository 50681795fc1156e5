"""Tables of time and signal from elsewhere: CSV and the like, npz, MATLAB's files.

The names of the columns say what they hold, with the unit in brackets or at the end, as `time_s`, `t [ms]`,
`x_am2_per_s`, `u1 (mV)`, `phi_deg`.  Where they do not, the caller names column and unit, or a file of the
same name with `.toml` at its end does:

    time = "t"
    time_unit = "ms"
    signal = ["a"]
    unit = "deg"

A column of a matrix is named as MATLAB names it, `data(:,2)`, and a field of a structure as `run.phi_deg`.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from drivers.errors import RecordingError
from drivers.text_files import read_text_file
from platform_daemon.core.schemas.recordings import TableColumn

from .angle_series import AngleSeries
from .array_files import matlab_table, npz_table, zipped_table
from .array_recording import Quantity, refuse_quantities, signal_of
from .recording import Recording
from .table import Table
from .text_table import text_table
from .unit_conversion import conversion, is_dimensionless, is_unit

_READERS = {".npz": npz_table, ".mat": matlab_table, ".zip": zipped_table}
_OTHERS = {
    **dict.fromkeys((".xls", ".xlsx", ".ods"), "save the sheet as CSV, and open that"),
    ".trk": "export its table by Tracker (File > Export > Data File), and open that",
}
_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", *_READERS, *_OTHERS)
_MATRIX_COLUMN = re.compile(r"^(.*)\(:,\s*(\d+)\)$")
_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\])]+)[\])]\s*$")
_ENDINGS = {
    **{"am2_per_s": "A m^2/s", "mam2_per_s": "mA m^2/s", "uam2_per_s": "uA m^2/s", "v": "V", "mv": "mV", "uv": "uV"},
    **{"rad": "rad", "mrad": "mrad", "deg": "deg", "s": "s", "ms": "ms", "us": "us", "ns": "ns"},
}
_ONE_ANGLE = "an angle is one signal, fitted by itself"
_ANGLE = re.compile(r"[θϑφϕ]|(?<![a-z])(phi|theta|angle|winkel)(?![a-z])", re.IGNORECASE)
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
    return path.suffix.lower() in _SUFFIXES


def columns_in(path: Path) -> tuple[TableColumn, ...]:
    """The columns of a table and what each is taken for, also of a table that is not readable as a signal yet.

    Raises RecordingError for a file that is no table, and for a column that the file next to it names and is not there.
    """
    told, table = _columns_of_toml(path), _table(path)
    time = told.time or _time_like(table)
    signals = told.signal or (() if time is None else _signal_names(table, time, told.unit))
    found = []
    every = [each for name in table for each in (_parts(name, table[name]) if time is None else (name,))]
    for name in dict.fromkeys((*every, *(() if time is None else (time,)), *signals)):
        values = _column(table, name, path)
        lowest, highest = finite_range(values)
        said = told.time_unit if name == time else told.unit if name in signals else None
        found.append(
            TableColumn(
                name=name,
                shape=values.shape,
                unit=said or _unit_of(table, name),
                read_as="time" if name == time else "signal" if name in signals else None,
                lowest=lowest,
                highest=highest,
            )
        )
    return tuple(found)


def finite_range(values: NDArray[np.float64]) -> tuple[float | None, float | None]:
    """Smallest and largest finite number; None: there is none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (None, None)


def _parts(name: str, values: NDArray[np.float64]) -> tuple[str, ...]:
    """The names of a matrix's columns where these may be time and signal, else the name of the array."""
    narrow = values.ndim == 2 and values.shape[0] > values.shape[1] > 1
    return tuple(f"{name}(:,{k})" for k in range(1, values.shape[1] + 1)) if narrow else (name,)


def lines_missing(columns: Sequence[TableColumn]) -> tuple[str, ...]:
    """Lines of the file next to a table with which it is a signal: names as they are likely, and units to be corrected.

    Empty if the columns say enough.
    """
    signals = [each for each in columns if each.read_as == "signal"]
    time = next((each for each in columns if each.read_as == "time"), None)
    quantities = {quantity_of(each.unit) for each in signals}
    one = len(quantities) == 1 and None not in quantities and (quantities != {"angle"} or len(signals) == 1)
    if one and time is not None and time.unit is not None and conversion(time.unit, "s"):
        return ()
    if len(columns) < 2:  # nothing that both could be
        return ()
    first = time or columns[0]
    others = signals or [each for each in columns if each is not first]
    angles = [each for each in others if quantity_of(each.unit) == "angle" or _ANGLE.search(each.name)]
    taken = angles[:1] or [each for each in others if quantity_of(each.unit) == quantity_of(others[0].unit)]
    units = [each.unit for each in taken if quantity_of(each.unit)] or ["deg" if angles else "V"]
    time_unit = first.unit if first.unit and conversion(first.unit, "s") else "s"
    names = json.dumps([each.name for each in taken], ensure_ascii=False)
    return (
        f"time = {json.dumps(first.name, ensure_ascii=False)}",
        f"time_unit = {json.dumps(time_unit, ensure_ascii=False)}",
        f"signal = {names}",
        f"unit = {json.dumps(units[0], ensure_ascii=False)}",
    )


def read_columns(path: Path, columns: Columns | None = None) -> Recording | AngleSeries:
    """The signal in a table.

    columns: which ones; None: as their names or the file next to it say.  Raises RecordingError for a file that is no
    table, a column that is not there or has no unit, and as signal_of.
    """
    columns = columns or _columns_of_toml(path)
    table = _table(path)
    time = columns.time or _time_name(table, path)
    stamps = _column(table, time, path).reshape(-1)
    time_s = stamps * _factor(columns.time_unit or _unit_of(table, time), "s", f"{path}: {time}", "time_unit")
    names = columns.signal or _signals_there(table, time, columns.unit, path)
    units = {name: columns.unit or _unit_of(table, name) for name in names}
    quantity, signal = _signal({name: _column(table, name, path) for name in names}, stamps.size, units, path)
    _refuse_missing(table, (time, *names), path)
    _refuse_signs(table, names, columns.unit, path)
    if quantity == "angle" and signal.ndim == 2 and signal.shape[0] > 1 and signal.shape[1] == stamps.size:
        raise _several_angles([each for name in names for each in _parts(name, _column(table, name, path))], path)
    read = signal_of(time_s, signal, quantity, where=str(path))
    return replace(read, size_bytes=path.stat().st_size) if isinstance(read, Recording) else read


def _table(path: Path) -> Table:
    suffix = path.suffix.lower()
    if suffix in _OTHERS:
        raise RecordingError(f"a file in {suffix} is not read", where=str(path), remedy=_OTHERS[suffix])
    try:
        return _READERS[suffix](path) if suffix in _READERS else text_table(path.read_bytes(), str(path))
    except OSError as error:
        remedy = "name a file that can be read"
        raise RecordingError("cannot be read", where=str(path), why=str(error), remedy=remedy) from None


def _column(table: Table, name: str, path: Path) -> NDArray[np.float64]:
    """Raises RecordingError."""
    if name in table:
        return table[name]
    found = _MATRIX_COLUMN.match(name)
    if found and found[1] in table and table[found[1]].ndim == 2 and 1 <= int(found[2]) <= table[found[1]].shape[1]:
        return table[found[1]][:, int(found[2]) - 1]
    if name in table.left_out:
        raise _no_numbers(name, table, path)
    there = [f"{each} ({' x '.join(map(str, table[each].shape))})" if table[each].ndim > 1 else each for each in table]
    remedy = f"one of: {', '.join(map(repr, there[:20]))}"
    raise RecordingError(f"there is no column {name!r}", where=str(path), remedy=remedy)


def _no_numbers(name: str, table: Table, path: Path) -> RecordingError:
    """The error for a column that is there, and was left out."""
    reason = table.left_out[name]
    remedy = "write real numbers there, or name another column, as signal = ['NAME'] or time = 'NAME'"
    what = f"the column {name!r} holds no real numbers" if name not in table.counters else f"no column is {name!r}"
    return RecordingError(what, where=str(path), why=reason, remedy=f"{remedy}, in {path.name}.toml")


def quantity_of(unit: str | None) -> Quantity | None:
    """What a signal in this unit is; None: no signal has it, as none is a plain number in % or counts."""
    if not unit or is_dimensionless(unit):
        return None
    return next((each for each, si in _QUANTITIES.items() if conversion(unit, si)), None)


def _signals_there(table: Table, time: str, unit: str | None, path: Path) -> tuple[str, ...]:
    """The same as _signal_names.

    Raises RecordingError if one that may be meant holds no real numbers, and no other one has the unit of a signal.
    """
    names = _signal_names(table, time, unit)
    if not any(quantity_of(_unit_of(table, name)) for name in names):
        for name in table.left_out:
            if name in table.complex_names or quantity_of(_unit_in(name)) or _ANGLE.search(name):
                raise _no_numbers(name, table, path)
    if names:
        return names
    why = "; ".join(f"{name!r}: {reason}" for name, reason in table.left_out.items()) or f"there is only {time!r}"
    remedy = "write a column of real numbers beside it"
    raise RecordingError("no column can be the signal", where=str(path), why=why, remedy=remedy)


def _several_angles(names: Sequence[str], path: Path) -> RecordingError:
    shown = ", ".join(map(repr, names[:10]))
    line = f"signal = [{json.dumps(names[0], ensure_ascii=False)}]"
    remedy = f"choose one by the line {line} in {path.name}.toml"
    return RecordingError(f"{len(names)} columns are angles: {shown}", where=str(path), why=_ONE_ANGLE, remedy=remedy)


def _refuse_signs(table: Table, names: Sequence[str], unit: str | None, path: Path) -> None:
    """Raises RecordingError for numbers with degree signs that are said to be in another unit."""
    for name in names:
        said, cells = unit or _unit_in(name), table.units.get(name)
        if table.lines is not None and cells and said and conversion(said, "rad") != conversion(cells, "rad"):
            what = f"the numbers of the column {name!r} have degree signs, and are said to be in {said!r}"
            raise RecordingError(what, where=str(path), remedy="say one unit: leave the signs out, or say deg")


def _refuse_missing(table: Table, names: Sequence[str], path: Path) -> None:
    """Raises RecordingError for cells of a text that are empty or no finite number, naming the line."""
    for name in names:
        if table.lines is None or name not in table:
            continue
        bad = np.flatnonzero(~np.isfinite(table[name]))
        if bad.size:
            many = (
                f"{bad.size} cells of the column {name!r} are" if bad.size > 1 else f"a cell of the column {name!r} is"
            )
            what = f"{many} empty, or no finite numbers"
            why = f"the first is in line {table.lines[bad[0]]}"
            remedy = "leave these lines out at the ends, or write what was measured"
            raise RecordingError(what, where=str(path), why=why, remedy=remedy)


def _signal_names(table: Table, time: str, unit: str | None) -> tuple[str, ...]:
    """All but time, and what is in a unit of no signal, as phyphox exports speeds beside angles."""
    rest = [name for name in table if name != time and table[name].size > 1]
    units = {name: _unit_of(table, name) for name in rest}
    signals = [name for name in rest if unit or not units[name] or quantity_of(units[name])]
    return tuple(signals or rest)


def _signal(
    columns: Mapping[str, NDArray[np.float64]], samples: int, units: Mapping[str, str | None], path: Path
) -> tuple[Quantity, NDArray[np.float64]]:
    """What the columns are, and their samples in SI, (channels, n)."""
    rows: list[NDArray[np.float64]] = []
    found: dict[Quantity, str] = {}
    for name, values in columns.items():
        said = units[name]
        quantity = quantity_of(said)
        if quantity is None:
            raise _no_unit(name, said, path, "unit", "A m^2/s or V, or of an angle rad or deg")
        found[quantity] = name
        row = np.atleast_2d(values)
        lies = row.ndim == 2 and row.shape[0] == samples != row.shape[1]  # a channel in each column, as in MATLAB
        rows.append((row.T if lies else row) * _factor(said, _QUANTITIES[quantity], f"{path}: {name}", "unit"))
    if len(found) != 1:
        raise refuse_quantities(list(columns), str(path))
    if len({row.shape[-1] for row in rows}) > 1:
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
    line = f"the line {key} = 'UNIT' besides time and signal"
    brackets = _BRACKETS.match(name)
    stem = brackets[1] if said and brackets else name
    remedy = f"call the column `{stem} [UNIT]`, or write {path.name}.toml with {line}, as platform-daemon info shows it"
    return RecordingError(what, where=str(path), why=f"it must be {wanted}, or be converted to that", remedy=remedy)


def _unit_of(table: Table, name: str) -> str | None:
    """What its cells say, else what its name says."""
    return table.units.get(name) or _unit_in(name)


def _unit_in(name: str) -> str | None:
    column = _MATRIX_COLUMN.match(name)
    if column:
        return _unit_in(column[1])
    found = _BRACKETS.match(name)
    if found:
        return found[2]
    lower = name.lower()
    ends = [ending for ending in _ENDINGS if lower.endswith(f"_{ending}") or lower == ending]
    return _ENDINGS[max(ends, key=len)] if ends else None


def _time_like(table: Table) -> str | None:
    """The column whose name begins with t or time, one with a unit of time first; None: there is none.

    One in another unit, as a temperature, is none.
    """
    found: list[tuple[bool, bool, str]] = []
    for name in table:
        unit = _unit_of(table, name)
        if not _called_time(name):
            continue
        known = bool(unit and conversion(unit, "s"))
        if known or not (unit and is_unit(unit)):
            found.append((not known, not known and not name.lower().startswith("time"), name))
    return min(found, key=lambda each: each[:2])[2] if found else None


def _called_time(name: str) -> bool:
    brackets = _BRACKETS.match(name)
    stem = (brackets[1] if brackets else name).rpartition(".")[2].strip().lower()
    return stem in ("t", "time") or re.match(r"^(t|time)_[a-z]+$", stem) is not None


def _time_name(table: Table, path: Path) -> str:
    """The same.  Raises RecordingError if there is none."""
    found = _time_like(table)
    if found is not None:
        return found
    text = next((name for name in table.left_out if _called_time(name)), None)
    if text is not None:
        raise _no_numbers(text, table, path)
    told = "time = 'NAME', signal = ['NAME'], time_unit = 's', unit = 'deg'"
    lines = f"{told} (or another unit), as platform-daemon info shows them"
    remedy = f"call it time_s, or write {path.name}.toml with the lines {lines}"
    why = f"the columns of numbers are {', '.join(map(repr, table)) or 'none'}"
    left = "".join(f"; {name!r} is left out: {reason}" for name, reason in list(table.left_out.items())[:5])
    raise RecordingError("no column is called time", where=str(path), why=why + left, remedy=remedy)


def _columns_of_toml(path: Path) -> Columns:
    toml = path.with_name(f"{path.name}.toml")
    if not toml.is_file():
        return Columns()
    try:
        table = tomllib.loads(read_text_file(toml))
    except (OSError, ValueError) as error:
        raise RecordingError("is no TOML file", where=str(toml), why=str(error), remedy="correct it") from None
    try:
        return Columns.model_validate(table)
    except ValidationError as error:
        first = error.errors()[0]
        where = f"{toml}: {'.'.join(map(str, first['loc']))}"
        remedy = f"the keys are {', '.join(Columns.model_fields)}: names and units are texts, signal is a list of names"
        raise RecordingError(first["msg"], where=where, remedy=remedy) from None

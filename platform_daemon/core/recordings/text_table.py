"""Tables as text: CSV with any separator, with a decimal comma, with headers of other programs, and Octave's own text.

What programs write differs in four things, each of which the text itself tells: the encoding (a byte order mark, or
bytes that are no UTF-8), the separator and the decimal mark (those with which the last line is most numbers), the line
of names (the last one before the numbers, or the last comment, as numpy.savetxt writes it), and a column that only
counts the rows (as pandas and R write it).
"""

from __future__ import annotations

import codecs
import csv
import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

Table = dict[str, NDArray[np.float64]]
"""Columns by name; of a table without names by their numbers from 0."""
OCTAVE = "# Created by Octave"
_COMMENTS = ("#", "%")
_FORMATS = (("\t", "."), (";", "."), (",", "."), (None, "."), ("\t", ","), (";", ","), (None, ","))
"""Separator (None: blanks) and decimal mark, the likelier first."""
_JUDGED = 5  # lines, the last ones
_MISSING = ("", "NA")
_UNITS_ROW = re.compile(r"^\s*[\[(].*[\])]\s*$")
_COUNTS_ROWS = ("", "Unnamed: 0", "index")


def decoded(content: bytes) -> str:
    """Text of a file: by its byte order mark, as UTF-8, or else in the encoding of Windows, whose `°` is one byte."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252")


def text_table(content: bytes, where: str) -> Table:
    """The columns of a text.  Raises RecordingError for what is no table, naming the line."""
    try:
        text = decoded(content)
    except UnicodeDecodeError as error:
        remedy = "save it as text in UTF-8"
        raise RecordingError("cannot be read as text", where=where, why=str(error), remedy=remedy) from None
    if text.startswith(OCTAVE):
        return octave_table(text, where)
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if lines and re.fullmatch(r"sep=.\s*", lines[0][1]):  # Excel's
        lines = lines[1:]
    comments = [line.strip().lstrip("#% ") for _, line in lines if line.strip().startswith(_COMMENTS)]
    rows = [(k, line) for k, line in lines if not line.strip().startswith(_COMMENTS)]
    if not rows:
        raise _no_table(where)
    separator, mark = _format_of([line for _, line in rows[-_JUDGED:]])
    cells = [(k, _cells(line, separator)) for k, line in rows]
    wide = Counter(len(each) for _, each in cells).most_common(1)[0][0]
    if wide > 1 and not any(each[-1] for _, each in cells if len(each) == wide):  # each line ends with a separator
        wide -= 1
        cells = [(k, each[:-1] if len(each) > wide else each) for k, each in cells]
    first = next((i for i, (_, each) in enumerate(cells) if len(each) == wide and _share(each, mark) >= 0.5), None)
    if first is None or len(cells) - first < 2:
        raise _no_table(where)
    names = _names([each for _, each in cells[:first]], comments, separator, wide)
    return _columns(names, cells[first:], mark, where)


def _no_table(where: str) -> RecordingError:
    return RecordingError("holds no table", where=where, remedy="write a line of names, then a line per sample")


def _format_of(lines: Sequence[str]) -> tuple[str | None, str]:
    """Separator and decimal mark with which these lines are most numbers."""

    def fits(form: tuple[str | None, str]) -> tuple[float, float]:
        cells = [_cells(line, form[0]) for line in lines]
        shares = [_share(each, form[1]) for each in cells]
        return sum(shares), sum(share * len(each) for share, each in zip(shares, cells, strict=True))

    return max(_FORMATS, key=fits)  # the first of those that are as good


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _share(cells: Sequence[str], mark: str) -> float:
    """How many of the cells that are not empty are numbers."""
    filled = [cell for cell in cells if cell not in _MISSING]
    return sum(_number(cell, mark) is not None for cell in filled) / max(len(filled), 1)


def _number(cell: str, mark: str) -> float | None:
    """None: it is none; NaN: it is missing."""
    try:
        return math.nan if cell in _MISSING else float(cell.replace("_", "?").replace(mark, "."))
    except ValueError:
        return None


def _names(heads: list[list[str]], comments: list[str], separator: str | None, wide: int) -> list[str]:
    """The names of the columns, from the lines before the numbers, or else from the last comment that has as many."""
    rows = [cells for cells in heads if len(cells) == wide]
    if len(rows) > 1 and all(_UNITS_ROW.match(cell) for cell in rows[-1]):  # a line of units below that of names
        return [f"{name} {unit}" for name, unit in zip(rows[-2], rows[-1], strict=True)]
    if rows:
        return rows[-1]
    if heads and len(heads[-1]) == wide - 1:  # the column that counts the rows has no name, and no separator either
        return ["", *heads[-1]]
    for comment in reversed(comments):
        for mark in (separator, ",", None):
            found = _cells(comment, mark)
            if len(found) == wide:
                return found
    return [str(k) for k in range(wide)]


def _columns(names: list[str], rows: list[tuple[int, list[str]]], mark: str, where: str) -> Table:
    """Without those of text.  Raises RecordingError for a line that is not like the others."""
    values = np.empty((len(rows), len(names)))
    texts: dict[int, tuple[int, str]] = {}  # of each column with text: how many cells, and the place of the first
    for i, (line, cells) in enumerate(rows):
        if len(cells) != len(names):
            why = f"line {line} has {len(cells)}, the others {len(names)}"
            remedy = "write as many in each line, separated alike"
            raise RecordingError("lines have different numbers of columns", where=where, why=why, remedy=remedy)
        for k, cell in enumerate(cells):
            number = _number(cell, mark)
            if number is None:
                count, place = texts.get(k, (0, f"{cell!r} in line {line} is no number"))
                texts[k], number = (count + 1, place), math.nan
            values[i, k] = number
    found: Table = {}
    for k, name in enumerate(names):
        count, place = texts.get(k, (0, ""))
        if 0 < count < len(rows):
            remedy = f"correct it; the column is {name!r}"
            raise RecordingError("a line is no row of numbers", where=where, why=place, remedy=remedy)
        counts_rows = k == 0 and name in _COUNTS_ROWS and (np.diff(values[:, 0]) == 1.0).all()
        if count or counts_rows:
            continue
        called = name or f"column {k}"
        if called in found:
            remedy = "give every column a name of its own"
            raise RecordingError(f"two columns are called {called!r}", where=where, remedy=remedy)
        found[called] = values[:, k]
    return found


def octave_table(text: str, where: str) -> Table:
    """The variables of a file that Octave wrote by `save -text`: matrices and scalars, others are left out.

    A matrix of several rows and columns is (rows, columns).  Raises RecordingError.
    """
    found: Table = {}
    for block in re.split(r"^# name: ", text, flags=re.MULTILINE)[1:]:
        name, *lines = block.splitlines()
        heads = dict(re.findall(r"^# (\w+): (.*)$", block, flags=re.MULTILINE))
        kind = heads.get("type", "")
        if kind not in ("matrix", "scalar"):
            continue
        numbers = " ".join(line for line in lines if not line.startswith("#"))
        try:
            values = np.array(numbers.replace("NA", "nan").split(), dtype=np.float64)
            shape = (1, 1) if kind == "scalar" else (int(heads["rows"]), int(heads["columns"]))
            found[name.strip()] = vector_or_matrix(values.reshape(shape))
        except (KeyError, ValueError) as error:
            remedy = "save it again, as 2-D arrays of real numbers"
            raise RecordingError(f"{name!r} cannot be read", where=where, why=str(error), remedy=remedy) from None
    return only_arrays(found.items(), where)


def vector_or_matrix(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """A matrix of one row or column as (n,), any other as it is."""
    return values.reshape(-1) if values.ndim == 2 and 1 in values.shape else values


def only_arrays(variables: Iterable[tuple[str, NDArray[np.float64]]], where: str) -> Table:
    """Without scalars.  Raises RecordingError if nothing is left."""
    found = {name: each for name, each in variables if each.size > 1}
    if not found:
        remedy = "save time and signal as arrays of numbers, as save('own.mat', 'time_s', 'phi_rad'); no table objects"
        raise RecordingError("holds no array of numbers", where=where, remedy=remedy)
    return found

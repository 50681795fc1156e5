"""Tables as text: CSV with any separator, with a decimal comma, with headers of other programs, and Octave's own text.

What programs write differs in four things, each of which the text itself tells: the encoding (a byte order mark, or
bytes that are no UTF-8), the separator and the decimal mark (those with which lines from all over the text are most
numbers), the line of names (the last one before the numbers, or the last comment, as numpy.savetxt writes it), and a
column that only counts the rows (as pandas and R write it).  A text is read in blocks, so that a long one needs little
more memory than its numbers.
"""

from __future__ import annotations

import codecs
import csv
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

from .octave_text import OCTAVE, octave_table
from .table import Table
from .text_cells import DEGREE, MISSING, Shape, names_above, number_in, shape_of

_COMMENTS = ("#", "%")
_BLOCK = 1 << 20  # characters
_JUDGED = 400  # lines, from all over the text
_SHOWN = 30  # characters of a cell in an error
_COUNTS_ROWS = ("", "unnamed: 0", "index")
_COUNTERS = ("n", "no", "no.", "nr", "nr.", "#", "row", "sample")
"""Names of columns that count the rows, the latter where they do so from 0 or 1."""
_Lines = list[tuple[int, str]]


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
    judged, comments = _judged_lines(text)
    if not judged:
        raise _no_table(where)
    shape = shape_of(judged)
    heads, start = _heads(text, shape, where)
    if shape.trailing and any(
        len(cells) > shape.width for cells in heads
    ):  # a column without a number, but with a name
        shape = shape._replace(trailing=False, width=shape.width + 1)
    rows = _Rows(shape, where)
    for block in _blocks(text):
        rows.add([(k, line) for k, line in block if k >= start])
    if rows.count < 2:
        raise _no_table(where)
    del text  # a long one takes more memory than its numbers, which are doubled for a moment now
    return rows.table(names_above(heads, comments, shape))


def _no_table(where: str) -> RecordingError:
    return RecordingError("holds no table", where=where, remedy="write a line of names, then a line per sample")


def _blocks(text: str) -> Iterator[_Lines]:
    """The lines with anything in them, with their numbers from 1, without Excel's that names the separator."""
    end = "\n" if "\n" in text else "\r"
    at, number = 0, 1
    while at < len(text):
        stop = text.find(end, min(at + _BLOCK, len(text)))
        stop = len(text) if stop < 0 else stop + 1
        lines = text[at:stop].splitlines()
        first = 1 if at == 0 and lines and re.fullmatch(r"sep=.\s*", lines[0]) else 0
        yield [(number + k, line) for k, line in enumerate(lines) if k >= first and line and not line.isspace()]
        at, number = stop, number + len(lines)


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(_COMMENTS)


def _judged_lines(text: str) -> tuple[list[str], list[str]]:
    """Some lines from all over the text but its beginning, where names are, and the comments."""
    parts: list[list[str]] = []
    comments: list[str] = []
    for block in _blocks(text):
        rows = [line for _, line in block if not _is_comment(line)]
        if len(rows) < len(block):
            comments += [line.strip().lstrip("#% ") for _, line in block if _is_comment(line)]
        parts.append(rows[:: max(1, len(rows) // _JUDGED)])
    parts = parts[:: max(1, len(parts) // 4)]
    judged = [line for part in parts for line in part]
    return judged[len(judged) // 4 :], comments


def _heads(text: str, shape: Shape, where: str) -> tuple[list[list[str]], int]:
    """(the cells of the lines before the numbers, the line with which these begin).  Raises RecordingError."""
    heads: list[list[str]] = []
    named, damaged = False, ""
    for block in _blocks(text):
        for number, line in block:
            if _is_comment(line):
                continue
            cells = _cells(number, line, shape, where)
            if shape.is_row(cells):
                if named and damaged:
                    remedy = "correct it"
                    raise RecordingError("a line is no row of numbers", where=where, why=damaged, remedy=remedy)
                return heads, number
            heads.append(cells)
            if len(cells) != shape.width:
                continue
            numbers = [each is not None and not math.isnan(each) for each in (number_in(c, shape.mark) for c in cells)]
            # A line of names may hold numbers, of channels, but does not begin with one.
            named = named or not any(numbers) or numbers[0]
            damaged = f"line {number} has a number, and a cell that is none" if any(numbers) else ""
        break
    raise _no_table(where)


def _cells(number: int, line: str, shape: Shape, where: str) -> list[str]:
    try:
        return shape.cells(line)
    except csv.Error as error:
        remedy = "write a line of names, then a line per sample, each with a number in every cell"
        why = f"line {number}: {error}"
        raise RecordingError("is no table of numbers", where=where, why=why, remedy=remedy) from None


class _Rows:
    """The numbers of a text, block by block."""

    def __init__(self, shape: Shape, where: str) -> None:
        self.shape, self.where, self.count = shape, where, 0
        self._values: list[NDArray[np.float64]] = []
        self._lines: list[NDArray[np.int32]] = []
        self._texts: dict[int, tuple[int, str, int]] = {}  # of a column: how many, the first, its line
        self._degrees: Counter[int] = Counter()
        self._filled: Counter[int] = Counter()

    def add(self, block: _Lines) -> None:
        """Raises RecordingError for a line that is not like the others."""
        rows = [(k, line) for k, line in block if not _is_comment(line)]
        if not rows:
            return
        values = self._plain([line for _, line in rows])
        self._values.append(self._any(rows) if values is None else values)
        self._lines.append(np.array([k for k, _ in rows], dtype=np.int32))
        self.count += len(rows)

    def _plain(self, lines: Sequence[str]) -> NDArray[np.float64] | None:
        """Of a block in which every cell is a number; None: it is another."""
        mark, separator, width = self.shape.mark, self.shape.separator, self.shape.width
        if self.shape.trailing or any(sign in line for line in lines for sign in ('"', "_")):
            return None
        cells = [line.replace(mark, ".").split(separator) for line in lines]
        if any(len(each) != width for each in cells):
            return None
        try:
            flat = np.fromiter(map(float, chain.from_iterable(cells)), np.float64, len(cells) * width)
        except ValueError:
            return None
        for k in range(width):
            self._filled[k] += len(lines)
        return flat.reshape(-1, width)

    def _any(self, rows: _Lines) -> NDArray[np.float64]:
        width, mark = self.shape.width, self.shape.mark
        values = np.full((len(rows), width), np.nan)
        for i, (line, text) in enumerate(rows):
            cells = _cells(line, text, self.shape, self.where)
            if len(cells) != width:
                why = f"line {line} has {len(cells)}, the others {width}"
                remedy = "write as many in each line, separated alike"
                raise RecordingError(
                    "lines have different numbers of columns", where=self.where, why=why, remedy=remedy
                )
            for k, cell in enumerate(cells):
                number = number_in(cell, mark)
                if number is None:
                    count, first, place = self._texts.get(k, (0, cell, line))
                    self._texts[k] = (count + 1, first, place)
                elif cell not in MISSING:
                    self._filled[k] += 1
                    self._degrees[k] += cell.endswith(DEGREE)
                    values[i, k] = number
        return values

    def table(self, names: Sequence[str]) -> Table:
        """Without columns of text.  Raises RecordingError."""
        values = np.concatenate(self._values)
        self._values.clear()
        found = Table()
        found.lines = np.concatenate(self._lines)
        for k, name in enumerate(names):
            called = name or f"column {k}"
            reason = self._no_numbers(k, called)
            if reason:
                found.left_out.setdefault(called, reason)
            elif k == 0 and _counts_rows(name, values[:, 0]):
                found.left_out[called] = "it only counts the rows"
                found.counters.add(called)
            elif called in found:
                remedy = "give every column a name of its own, or its group's in the line above"
                raise RecordingError(f"two columns are called {called!r}", where=self.where, remedy=remedy)
            else:
                found[called] = values[:, k]
                if self._degrees[k]:
                    found.units[called] = "deg"
        return found

    def _no_numbers(self, k: int, name: str) -> str:
        """Why the column is none of numbers; empty: it is one.  Raises RecordingError for one that is so in part."""
        count, cell, line = self._texts.get(k, (0, "", 0))
        shown = repr(cell if len(cell) <= _SHOWN else f"{cell[:_SHOWN]}...")
        remedy = f"correct it; the column is {name!r}"
        if count == self.count or (count and not self._filled[k]):
            return f"it holds text, {shown} in line {line}"
        if not self._filled[k]:
            return "it is empty"
        if count:
            why = f"{shown} in line {line} is no number"
            raise RecordingError("a line is no row of numbers", where=self.where, why=why, remedy=remedy)
        if self._degrees[k] not in (0, self._filled[k]):
            why = f"{self._degrees[k]} cells of {self._filled[k]} have a degree sign"
            raise RecordingError("a column is in degrees in part", where=self.where, why=why, remedy=remedy)
        return ""


def _counts_rows(name: str, values: NDArray[np.float64]) -> bool:
    if not (np.diff(values) == 1.0).all():
        return False
    return name.lower() in _COUNTS_ROWS or (name.lower() in _COUNTERS and values[0] in (0.0, 1.0))

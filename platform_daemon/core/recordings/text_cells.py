"""The cells of a line of text: separator, decimal mark, numbers; and the names that stand above them."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from .unit_conversion import is_unit

_FORMATS = (("\t", "."), (";", "."), (",", "."), (None, "."), ("\t", ","), (";", ","), (None, ","))
"""Separator (None: blanks) and decimal mark, the likelier first."""
MISSING = ("", "NA")
DEGREE = "°"
_UNITS_ROW = re.compile(r"^\s*[\[(].*[\])]\s*$")


class Shape(NamedTuple):
    """How the rows of a text are written.

    Attributes:
        separator: of the cells; None: blanks.
        mark: of the decimals.
        width: cells of a row.
        trailing: each row ends with a further separator.
        numbers: the columns that hold numbers.
    """

    separator: str | None
    mark: str
    width: int
    trailing: bool
    numbers: tuple[int, ...]

    def cells(self, line: str) -> list[str]:
        """Those of a line, without the empty one behind a separator at its end.  Raises csv.Error."""
        found = cells_of(line, self.separator)
        return found[:-1] if self.trailing and len(found) > self.width and not found[-1] else found

    def is_row(self, cells: Sequence[str]) -> bool:
        """Has it the width of the others, and numbers where most of them have any?"""
        if len(cells) != self.width:
            return False
        found = [number_in(cells[k], self.mark) for k in self.numbers]
        return None not in found and not all(math.isnan(each or 0.0) for each in found)


def shape_of(lines: Sequence[str]) -> Shape:
    """The one with which these lines, rows of a table most of them, are most numbers."""

    def fits(form: tuple[str | None, str]) -> tuple[float, float]:
        cells = [_tried(line, form[0]) for line in lines]
        shares = [_share(each, form[1]) for each in cells]
        return sum(shares), sum(share * len(each) for share, each in zip(shares, cells, strict=True))

    separator, mark = max(_FORMATS, key=fits)  # the first of those that are as good
    rows = [_tried(line, separator) for line in lines]
    width = Counter(map(len, rows)).most_common(1)[0][0]
    rows = [row for row in rows if len(row) == width]
    trailing = width > 1 and not any(row[-1] for row in rows)
    width -= trailing
    filled = [[number_in(row[k], mark) is not None for row in rows if row[k] not in MISSING] for k in range(width)]
    numbers = tuple(k for k, found in enumerate(filled) if found and 2 * sum(found) >= len(found))
    return Shape(separator, mark, width, trailing, numbers)


def cells_of(line: str, separator: str | None) -> list[str]:
    """Raises csv.Error for a cell in quotes that is too long."""
    if separator is None:
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _tried(line: str, separator: str | None) -> list[str]:
    try:
        return cells_of(line, separator)
    except csv.Error:
        return [line]


def _share(cells: Sequence[str], mark: str) -> float:
    """How many of the cells that are not empty are numbers."""
    filled = [cell for cell in cells if cell not in MISSING]
    return sum(number_in(cell, mark) is not None for cell in filled) / max(len(filled), 1)


def number_in(cell: str, mark: str) -> float | None:
    """None: it is none; NaN: it is missing.  A degree sign behind it is left out."""
    try:
        bare = cell.removesuffix(DEGREE).replace("_", "?").replace(mark, ".")
        return math.nan if cell in MISSING else float(bare)
    except ValueError:
        return None


def names_above(heads: Sequence[Sequence[str]], comments: Sequence[str], shape: Shape) -> list[str]:
    """The names of the columns, from the lines before the numbers, or else from the last comment that has as many."""
    wide = shape.width
    full = [k for k, cells in enumerate(heads) if len(cells) == wide]
    if full:
        last = full[-1]
        before = full[-2] if len(full) > 1 else None
        if before is None or not _are_units(heads[last], heads[before]):
            return _told_apart(heads[last], heads[:last])
        names = _told_apart(heads[before], heads[:before])
        units = [cell if _UNITS_ROW.match(cell) else f"[{cell}]" if cell else "" for cell in heads[last]]
        return [f"{name} {unit}".strip() for name, unit in zip(names, units, strict=True)]
    if heads and len(heads[-1]) == wide - 1:  # the column that counts the rows has no name, and no separator either
        return ["", *heads[-1]]
    for comment in reversed(comments):
        for separator in (shape.separator, ",", None):
            found = _tried(comment, separator)
            if len(found) == wide:
                return found
    return [str(k) for k in range(wide)]


def _are_units(cells: Sequence[str], above: Sequence[str]) -> bool:
    """A line of units, in brackets or bare, below one of names."""
    if all(_UNITS_ROW.match(cell) for cell in cells):
        return True

    def bare(row: Sequence[str]) -> bool:
        return any(row) and all(is_unit(cell) for cell in row if cell)

    return bare(cells) and not bare(above)


def _told_apart(names: Sequence[str], heads: Sequence[Sequence[str]]) -> list[str]:
    """Names that several columns have with that of their group before them, which stands in the line above.

    Tracker writes the name of a point above the first of its columns, and empty cells above the others.
    """
    several = {name for name, count in Counter(names).items() if count > 1}
    if not several or not heads or not any(heads[-1]):
        return list(names)
    groups, group = [], ""
    for k in range(len(names)):
        group = (heads[-1][k] if k < len(heads[-1]) else "") or group
        groups.append(group)
    return [f"{group} {name}".strip() if name in several else name for name, group in zip(names, groups, strict=True)]

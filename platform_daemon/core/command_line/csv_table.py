"""Tables of the command line as CSV: the columns have the names of the keys of `--json`."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from platform_daemon.core.schemas.base import Schema

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def write_csv(path: Path | None, rows: Iterable[Schema | Mapping[str, Any]]) -> None:
    """Write a row per entry if a path is given; see `csv_text`.  Raises StorageError."""
    if path is not None:
        from platform_daemon.core.state.durable import write_file  # here, because HDF5 is loaded with it

        write_file(path, csv_text(rows).encode())


def csv_text(rows: Iterable[Schema | Mapping[str, Any]]) -> str:
    """A heading and a row per entry (RFC 4180, lines end with a line feed).

    A column is named by the path of its value in the JSON of the entry, as `parameters.f_nat_hz.std`, so that it holds
    the unit.  Numbers are written as in JSON; a cell is empty where the entry has no such key or null; a list is
    written as JSON; text is written as `text_cell`.
    """
    cells = [dict(_cells(row if isinstance(row, Mapping) else row.model_dump())) for row in rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in cells for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(cells)
    return text.getvalue()


def text_cell(text: str) -> str:
    """A person's text as a cell that no spreadsheet takes for a formula.

    A name such as `=HYPERLINK(...)` would be run by the program that opens the table; it gets an apostrophe in front,
    which spreadsheets take for "this is text" (OWASP, "CSV Injection").  Numbers written as text stay as they are.

    Example:
        >>> text_cell("=1+1"), text_cell("-0.5"), text_cell("T-07")
        ("'=1+1", '-0.5', 'T-07')
    """
    if not text.startswith(_FORMULA):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text


def _cells(entry: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Path and text of every value of an entry.  Raises ValueError for NaN and infinity, as JSON does."""
    for key, value in entry.items():
        if isinstance(value, Mapping):
            yield from _cells(value, f"{above}{key}.")
        elif value is None or isinstance(value, str):
            yield f"{above}{key}", text_cell(value or "")
        else:
            yield f"{above}{key}", json.dumps(value, allow_nan=False)

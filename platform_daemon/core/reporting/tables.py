"""Tables for the terminal, in as many parts below each other as its width takes."""

from __future__ import annotations

import shutil
from collections.abc import Sequence

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table

_FRAME_EDGES, _CELL_EDGES = 1, 3  # characters that a frame takes, and each of its cells
_UNBOUND = 200  # columns where there is no terminal


Column = tuple[str, list[str]]
"""A heading and the cells below it."""


def tables_text(title: str, index: Column, columns: Sequence[Column], last_apart: bool = False) -> str:
    """Columns below a title, cut into tables that the terminal is wide enough for; each begins with the index."""
    width = shutil.get_terminal_size((_UNBOUND, 24)).columns
    console = Console(width=width, markup=False, highlight=False, color_system=None)  # it is printed as plain text
    with console.capture() as capture:
        console.print(title, soft_wrap=True)
        for part in _parts(columns, width - _FRAME_EDGES - _width(index)):
            table = Table()
            for heading, _ in (index, *part):
                table.add_column(heading, justify="right", no_wrap=True)
            for k, cells in enumerate(zip(index[1], *(cells for _, cells in part), strict=True)):
                table.add_row(*cells, end_section=last_apart and k == len(index[1]) - 2)
            console.print(table)
    return capture.get().rstrip()


def _width(column: Column) -> int:
    return max(map(cell_len, (column[0], *column[1]))) + _CELL_EDGES


def _parts(columns: Sequence[Column], width: int) -> list[list[Column]]:
    parts: list[list[Column]] = [[]]
    for column in columns:
        if parts[-1] and sum(map(_width, (*parts[-1], column))) > width:
            parts.append([])
        parts[-1].append(column)
    return parts

"""Tables for the terminal."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table

from platform_daemon.schemas import DeviceReport, RecordingInfo

_UNBOUND = 200  # columns where there is no terminal
_FRAME_EDGES, _CELL_EDGES = 1, 3  # characters that a frame takes, and each of its cells
Column = tuple[str, list[str]]
"""A heading and the cells below it."""


def tables_text(title: str, index: Column, columns: Sequence[Column], last_apart: bool = False) -> str:
    """Columns below a title, cut into tables that the terminal is wide enough for; each begins with the index."""
    width = shutil.get_terminal_size((_UNBOUND, 24)).columns
    console = Console(width=width, markup=False, highlight=False)
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


def info_text(info: RecordingInfo) -> str:
    """What a recording holds, without what nobody knows; its shots as a table."""
    facts = info.model_dump()
    rows = [_flat(shot) for shot in facts.pop("shots")]
    told = {name: [row.get(name, "") for row in rows] for name in dict.fromkeys(name for row in rows for name in row)}
    index, *columns = [(name, cells) for name, cells in told.items() if any(cells)] or [("frame", [])]
    return "\n".join([*_lines(facts), *([tables_text("shots:", index, columns)] if rows else [])])


def _lines(facts: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    for key, value in facts.items():
        if isinstance(value, Mapping) and value:
            yield from (f"{indent}{key}:", *_lines(value, indent + "  "))
        elif _plain(value):
            yield f"{indent}{key}: {_plain(value)}"


def _flat(facts: Mapping[str, Any]) -> dict[str, str]:
    """Values as text by name; those of parts by their own names."""
    found: dict[str, str] = {}
    for key, value in facts.items():
        found |= _flat(value) if isinstance(value, Mapping) else {key: _plain(value)}
    return found


def _plain(value: Any) -> str:
    """A value as text; "" where there is nothing to say."""
    if value is None or value is False or value == {}:
        return ""
    if isinstance(value, list | tuple):
        return ", ".join(f"({_plain(v)})" if isinstance(v, list | tuple) else _plain(v) for v in value)
    return "yes" if value is True else f"{value:.9g}" if isinstance(value, float) else str(value)


def print_devices(reports: Sequence[DeviceReport]) -> None:
    """A row per device: who it is, its state, and what went wrong."""
    table = Table()
    for heading in ("device", "identity", "state", "error"):
        table.add_column(heading, overflow="fold")
    for report in reports:
        identity = " ".join(part for _, part in report.identity or () if part)
        state = ", ".join(f"{name} {_number(value)}" for name, value in report.state)
        table.add_row(report.device, identity or "-", state or "-", report.error or "-")
    Console().print(table)


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

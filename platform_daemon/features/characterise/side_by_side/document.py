"""A report as a PDF: its words, its tables, and its figures, a page each."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

from matplotlib.figure import Figure

from platform_daemon import __version__
from platform_daemon.core.reporting.figures import COLOURS, document_of, new_figure
from platform_daemon.features.characterise.report import WordedTable

from .tables import headings_of

_PAGE = (11.7, 8.3)  # A4, landscape, inches
_ROWS = 40  # of a table on a page
_COLOUR_OF_CELL = {"agrees": COLOURS[2], "differs": COLOURS[1]}


def pdf_of(title: str, said: Sequence[str], tables: Sequence[WordedTable], figures: Sequence[Figure]) -> bytes:
    """The document."""
    return document_of(_pages(title, said, tables, figures), title)


def _pages(
    title: str, said: Sequence[str], tables: Sequence[WordedTable], figures: Sequence[Figure]
) -> Iterator[Figure]:
    yield _first_page(title, said)
    for table in tables:
        rows = list(table.rows())
        for first in range(0, len(rows), _ROWS):
            yield _table_page(table, rows[first : first + _ROWS])
    yield from figures


def _first_page(title: str, said: Sequence[str]) -> Figure:
    figure = new_figure(*_PAGE)
    lines = [*said, f"platform-daemon {__version__}, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"]
    figure.text(0.05, 0.92, title, fontsize=16, va="top", parse_math=False)
    text = "\n\n".join("\n".join(textwrap.wrap(line, 130)) for line in lines)
    figure.text(0.05, 0.85, text, fontsize=10, va="top", parse_math=False)
    return figure


def _table_page(table: WordedTable, rows: Sequence[tuple[str, ...]]) -> Figure:
    figure = new_figure(*_PAGE)
    figure.suptitle(table.title, fontsize=12)
    axes = figure.subplots()
    axes.axis("off")
    drawn = axes.table([list(cells) for cells in rows], colLabels=list(headings_of(table)), loc="upper center")
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(7)
    drawn.auto_set_column_width(list(range(len(table.columns) + 1)))
    for cell in drawn.get_celld().values():
        cell.get_text().set_parse_math(False)
        cell.set(edgecolor="0.8", linewidth=0.5, height=1.0 / (_ROWS + 1))
        cell.get_text().set_color(_COLOUR_OF_CELL.get(cell.get_text().get_text(), "k"))
    if table.said:
        figure.supxlabel("\n".join(textwrap.wrap(table.said, 160)), fontsize=8)
    return figure

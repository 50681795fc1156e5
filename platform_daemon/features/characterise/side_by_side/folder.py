"""The report on several specimens as a folder: one page, one PDF, figures as SVG and PDF, tables as CSV and LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from matplotlib.figure import Figure

from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.reporting.figures import vector_of
from platform_daemon.core.reporting.page import page
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.characterise.report import WordedTable

from .document import pdf_of
from .tables import NamedTable, headings_of, table_latex


@dataclass(frozen=True)
class NamedFigure:
    """A figure, its caption, and the name of its files without ending."""

    name: str
    caption: str
    figure: Figure


@dataclass(frozen=True)
class SideBySide:
    """What the folder tells.

    Attributes:
        title: of page and PDF; said: sentences in front of everything.
        first: a table in front of the others that has files of its own; first_printed: the same for the PDF, where
            there is less room; None: there is none.
        first_widths: of its columns on the page, percent, so that it is never wider than the page.
    """

    title: str
    said: Sequence[str]
    tables: Sequence[NamedTable]
    figures: Sequence[NamedFigure]
    first: WordedTable | None = field(default=None)
    first_widths: Sequence[int] = field(default=())
    first_printed: WordedTable | None = field(default=None)


def write_folder(folder: Path, told: SideBySide) -> None:
    """Write all of it; what was there before is replaced.  Raises StorageError."""
    for name in ("tables", "figures"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    for named in told.tables:
        rows = (dict(zip(headings_of(named.table), cells, strict=True)) for cells in named.table.rows())
        write_csv(folder / "tables" / f"{named.name}.csv", rows)
        write_file(folder / "tables" / f"{named.name}.tex", table_latex(named.table).encode())
    for drawn in told.figures:
        write_file(folder / "figures" / f"{drawn.name}.svg", vector_of(drawn.figure, "svg"))
        write_file(folder / "figures" / f"{drawn.name}.pdf", vector_of(drawn.figure, "pdf"))
    write_file(folder / "report.html", page("side_by_side_page.html", {}, told=told, headings_of=headings_of))
    tables = [named.table for named in told.tables]
    if told.first_printed is not None:
        tables.insert(0, told.first_printed)
    for drawn in told.figures:  # now that the files without a title are written
        drawn.figure.suptitle(drawn.caption, fontsize=10)
    write_file(folder / "report.pdf", pdf_of(told.title, told.said, tables, [d.figure for d in told.figures]))

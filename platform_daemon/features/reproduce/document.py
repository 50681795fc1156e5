"""The report of a campaign as a PDF: the table of claims, the paper's tables, and its figures, a page each."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from matplotlib.figure import Figure

from platform_daemon import __version__
from platform_daemon.core.reporting.figures import COLOURS, document_of, new_figure
from platform_daemon.features.characterise.report import WordedTable

from .claims import contradictions
from .report import claim_cells, count_text
from .schema import Claims
from .tables import headings_of

_PAGE = (11.7, 8.3)  # A4, landscape, inches
_ROWS = 40
_HIGH = 0.021  # of a line, of the page's height
_TITLE = "The paper's numbers by one command"
_VERDICT_COLOUR = {"agrees": COLOURS[2], "differs": COLOURS[1]}
_CLAIM_COLUMNS = (
    ("label", 0.03), ("what", 0.205), ("paper", 0.655), ("ours", 0.72), ("tolerance", 0.79), ("verdict", 0.86)
)  # fmt: skip


def pdf_of(
    claims: Claims, tables: Sequence[tuple[str, WordedTable]], figures: Sequence[tuple[str, str, Figure]]
) -> bytes:
    """The document; figures get their caption as title."""
    return document_of(_pages(claims, tables, figures), _TITLE)


def _pages(
    claims: Claims, tables: Sequence[tuple[str, WordedTable]], figures: Sequence[tuple[str, str, Figure]]
) -> Iterator[Figure]:
    yield _first_page(claims)
    for first in range(0, len(claims.claims), _ROWS):
        yield _claims_page(claims, first)
    for name, table in tables:
        yield _table_page(name, table)
    for _, caption, figure in figures:
        figure.suptitle(caption, fontsize=10)
        yield figure


def _first_page(claims: Claims) -> Figure:
    figure = new_figure(*_PAGE)
    said = [f"The paper disagrees with itself: {text}." for text in contradictions()]
    lines = [count_text(claims) + ".", *said, f"Made by platform-daemon {__version__}."]
    figure.text(0.05, 0.92, _TITLE, fontsize=16, va="top")
    text = "\n\n".join("\n".join(textwrap.wrap(line, 130)) for line in lines)
    figure.text(0.05, 0.85, text, fontsize=10, va="top", parse_math=False)
    return figure


def _claims_page(claims: Claims, first: int) -> Figure:
    figure = new_figure(*_PAGE)
    for heading, x in _CLAIM_COLUMNS:
        figure.text(x, 0.95, heading, fontsize=8, weight="bold")
    for k, claim in enumerate(claims.claims[first : first + _ROWS]):
        y = 0.95 - (k + 1.4) * _HIGH
        for (heading, x), cell in zip(_CLAIM_COLUMNS, (claim.label, *claim_cells(claim)), strict=True):
            colour = _VERDICT_COLOUR.get(claim.verdict, "0.4") if heading == "verdict" else "k"
            figure.text(x, y, cell, fontsize=7, color=colour, parse_math=False)
    return figure


def _table_page(name: str, table: WordedTable) -> Figure:
    figure = new_figure(*_PAGE)
    figure.text(0.03, 0.94, f"{table.title} (tab:{name})" if name in _LABELLED else table.title, fontsize=12)
    axes = figure.subplots()
    axes.axis("off")
    drawn = axes.table([list(cells) for cells in table.rows()], colLabels=list(headings_of(table)), loc="center")
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(7)
    drawn.auto_set_column_width(list(range(len(table.columns) + 1)))
    figure.text(0.03, 0.08, "\n".join(textwrap.wrap(table.said, 160)), fontsize=8, parse_math=False)
    return figure


_LABELLED = {"measurement_parameter", "fit_results_quality", "model_params_fit_result", "quality_factors"}

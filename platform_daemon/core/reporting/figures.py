"""Figures: colours that the colour-blind tell apart, and PNG, SVG and PDF."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from platform_daemon.core.schemas.control_characters import encodable
from platform_daemon.core.state.durable import write_file

COLOURS = ("#1b6ca8", "#d1495b", "#3a7d44")
BEFORE, AFTER = COLOURS[1], COLOURS[0]


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG; the file appears whole or not at all."""
    write_file(path, png_of(figure, 110))


def png_of(figure: Figure, dpi: int) -> bytes:
    """A figure as the bytes of a PNG file; text in it as `encodable`: titles name files."""
    return _saved(figure, format="png", dpi=dpi)


def vector_of(figure: Figure, file_format: Literal["svg", "pdf"]) -> bytes:
    """A figure as the bytes of an SVG or PDF file, without the time at which it was made."""
    return _saved(figure, format=file_format, metadata={"Date" if file_format == "svg" else "CreationDate": None})


def document_of(figures: Iterable[Figure], title: str) -> bytes:
    """A PDF with a page for each figure."""
    from matplotlib.backends.backend_pdf import PdfPages

    buffer = BytesIO()
    with PdfPages(buffer, metadata={"Title": title, "CreationDate": None}) as document:
        for figure in figures:
            _make_encodable(figure)
            document.savefig(figure)
    return buffer.getvalue()


def _saved(figure: Figure, **options: Any) -> bytes:
    _make_encodable(figure)
    buffer = BytesIO()
    figure.savefig(buffer, **options)
    return buffer.getvalue()


def _make_encodable(figure: Figure) -> None:
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if (shown := encodable(text.get_text())) != text.get_text():
            text.set_text(shown)


def as_written(name: str) -> str:
    """A label that shows a person's text as it is: matplotlib sets what stands between two `$` as mathematics, and
    leaves a label that begins with `_` out of the legend."""
    shown = name.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def new_figure(width: float, height: float) -> Figure:
    """Of this size in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure

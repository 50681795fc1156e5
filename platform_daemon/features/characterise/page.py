"""A characterisation as one self-contained HTML page: words, tables and pictures; nothing is loaded from anywhere."""

from __future__ import annotations

from platform_daemon.core.reporting.page import page
from platform_daemon.core.schemas.value_sources import value_sources_text
from platform_daemon.features.fit.plot_data import RingDownPlotData
from platform_daemon.features.fit.report import frame_notes

from . import figures as plots
from .report import characterisation_tables
from .schema import CharacterisationReport


def characterisation_html(report: CharacterisationReport, shot: RingDownPlotData | None) -> bytes:
    """The page in UTF-8; shot: that of the figures, with its D30 fit, None if there is none."""
    fits = (("N50", report.n50_fits), ("D30", report.d30_fits))
    shown = next((f for f in report.d30_fits.good_frames if f.frame == report.shown_frame), None)
    return page(
        "characterisation_page.html",
        {},
        report=report,
        shot=shot,
        duration_s=None if shown is None else shown.window_s,
        tables=characterisation_tables(report),
        sources=value_sources_text(report.value_sources or ()).splitlines(),
        said=[(name, frame_notes(fit.frames)) for name, fit in fits],
        plots=plots,
    )

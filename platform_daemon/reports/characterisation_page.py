"""A characterisation as one self-contained HTML page: words, tables and pictures; nothing is loaded from anywhere."""

from __future__ import annotations

from platform_daemon.analysis import RingDownPlotData
from platform_daemon.schemas import CharacterisationReport

from .characterisation_tables import characterisation_tables
from .figures import characterisation as plots
from .fit_tables import frame_notes
from .page import page


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
        said=[(name, frame_notes(fit.frames)) for name, fit in fits],
        plots=plots,
    )

"""A diagnosis as one self-contained HTML page: words, tables and pictures; nothing is loaded from anywhere."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from platform_daemon.core.reporting.page import page
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.diagnosis.findings.residual_analysis import Scatter
from platform_daemon.diagnosis.report_schema import DiagnosisReport, TriedEffect
from platform_daemon.diagnosis.residual_comparison import ResidualComparison

from . import figures as plots
from . import report as text
from .parameter_trace_figure import draw_trace

_SHOWN = 8  # candidates at least, however unlikely


def diagnosis_html(report: DiagnosisReport, seen: ResidualComparison) -> bytes:
    """The page in UTF-8; report: with its files."""
    filters: dict[str, Callable[..., Any]] = {
        "effect_line": text.effect_line,
        "tentative_line": text.tentative_line,
        "grade": _grade,
        "next_line": text.next_line,
        "plain": text.plain,
        "where_line": text.where_line,
    }
    return page(
        "diagnosis_page.html",
        filters,
        report=report,
        seen=seen,
        likely=_likely(report.ranking),
        drifts=_drifts(seen),
        plots=plots,
        draw_trace=draw_trace,
        text=text,
    )


def _grade(sigma: float | None) -> str:
    """Colour of a disagreement in standard errors."""
    if sigma is None:
        return ""
    return "good" if round(sigma, 1) < 2.0 else "fair" if round(sigma, 1) < 4.0 else "poor"


def _likely(ranking: tuple[TriedEffect, ...]) -> list[TriedEffect]:
    return [t for k, t in enumerate(ranking) if (t.p_value or 0.0) < 0.5 or k < _SHOWN]


def _drifts(seen: ResidualComparison) -> Iterator[tuple[str, str, str, str]]:
    """Rows: parameter, scatter before and after, drift per shot with the named effects."""
    known = {s.name: s for s in seen.scatter_after}
    for before in seen.scatter_before:
        after, shown = known.get(before.name, before), definition_of(before.name)
        factor = shown.display_factor
        sd = after.drift_sd * factor
        drift = text.scientific(after.drift_per_shot * factor, None if math.isnan(sd) else sd)
        yield shown.heading, _spread(before, factor), _spread(after, factor), drift


def _spread(course: Scatter, factor: float) -> str:
    return f"{course.values.std(ddof=1) * factor:.3g}"

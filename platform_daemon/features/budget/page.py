"""Budgets as one page that loads nothing from anywhere."""

from __future__ import annotations

from platform_daemon.core.reporting.page import page

from .report import draw_budget, monte_carlo_line
from .schema import BudgetsReport


def budget_page(report: BudgetsReport) -> bytes:
    """The page in UTF-8."""
    return page(
        "budget_page.html", {"draw": draw_budget, "short": "{:.4g}".format, "checked": monte_carlo_line}, report=report
    )

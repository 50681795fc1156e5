"""Budgets as one page that loads nothing from anywhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from platform_daemon.core.reporting.page import page
from platform_daemon.core.schemas.parameters import definition_of

from .report import dof_text, draw_budget, monte_carlo_line, off_centre_line, rounded
from .schema import BudgetsReport


def budget_page(report: BudgetsReport) -> bytes:
    """The page in UTF-8."""
    filters: dict[str, Callable[..., Any]] = {
        "draw": draw_budget,
        "rounded": rounded,
        "dof": dof_text,
        "short": "{:.4g}".format,
        "unit": lambda quantity: definition_of(quantity).unit,
        "checked": monte_carlo_line,
        "place": off_centre_line,
    }
    return page("budget_page.html", filters, report=report)

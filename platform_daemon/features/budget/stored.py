"""The budget of a stored recording, as a function of what can be sent to another process."""

from __future__ import annotations

from pathlib import Path

from platform_daemon.core.schemas.base import NamedWindow
from platform_daemon.features.models.library import Library

from .schema import BudgetReport


def stored_budget(
    path: Path,
    quantity: str,
    shot: int | None,
    coverage: float,
    window: NamedWindow,
    variant: str | None,
    models: Library,
) -> BudgetReport:
    """Of a shot; None: of the mean of all, or of the only one.  Raises InputError, RecordingError."""
    # Here, because the process that sends it needs none of it: numba and scipy take 0.7 s of a processor to load.
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.measurement import open_for_fit
    from platform_daemon.features.models.resolve import resolve

    from .work import budgets_of
    from .written import one_report

    measurement, ask = open_for_fit(path, FitSettings(resolve(variant, models), window))
    found = budgets_of(measurement, ask, shot, coverage=coverage)
    return one_report(found, quantity)

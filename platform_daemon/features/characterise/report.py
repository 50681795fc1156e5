"""A characterisation in words: the paper's tables for the terminal and for the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from platform_daemon.core.reporting.numbers import spread
from platform_daemon.core.reporting.tables import Column, tables_text
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.core.schemas.value_sources import value_sources_text
from platform_daemon.features.budget.schema import BudgetReport

from .schema import (
    CharacterisationReport,
    FitDataset,
    ParameterStatistics,
    ParameterUncertainty,
    ShotStatistics,
    WindowComparison,
)

_NONE = "-"
_ORIENTATION = ("orientation error", "°", math.degrees(1.0))
_LABELS = {"n50": "N50", "d30": "D30"}


@dataclass(frozen=True)
class WordedTable:
    """A table as it is read; index: its first column; said: what its reader must know."""

    title: str
    index: Column
    columns: tuple[Column, ...]
    said: str = ""

    def rows(self) -> Iterator[tuple[str, ...]]:
        """Cells, row by row, the first column too."""
        yield from zip(self.index[1], *(cells for _, cells in self.columns), strict=True)


def characterisation_text(report: CharacterisationReport) -> str:
    """The tables and what is to be said of them, for the terminal."""
    parts = [tables_text(table.title, table.index, table.columns) for table in characterisation_tables(report)]
    sources = [value_sources_text(report.value_sources)] if report.value_sources else []
    return "\n".join([*parts, *sources, *(f"note: {note}" for note in report.notes)])


def parameter_rows(report: CharacterisationReport) -> list[dict[str, Any]]:
    """For a CSV: a row per recording, window and parameter (tab:model_params_fit_result), and of the D30 means u, k and
    U of the budgets."""
    budgets = {("d30", each.quantity): each for each in report.mean_budgets or ()}

    rows = []
    for fits in (report.n50, report.d30):
        for name, found in fits.parameters.items():
            row = {"file": report.file, "window": fits.window, "parameter": name, **found.model_dump()}
            mean = budgets.get((fits.window, name))
            worth = (None, None, None) if mean is None else (mean.u, mean.k, mean.U)
            rows.append({**row, **dict(zip(("mean_u", "mean_k", "mean_U"), worth, strict=True))})
    return rows


def characterisation_tables(report: CharacterisationReport) -> tuple[WordedTable, ...]:
    """The paper's tables, in its order."""
    return (
        _measured(report),
        _fit_quality(report),
        _parameters(report),
        _compared(report),
        _uncertainties(report),
        _mean_budgets(report),
        _quality_factors(report),
    )


def _measured(report: CharacterisationReport) -> WordedTable:
    """tab:measurement_parameter."""
    made = report.excitation
    cells = (
        ("f_TX / Hz", _NONE if made is None else f"{made.requested_hz:.6g}"),
        ("t_TX / s", _NONE if made is None else f"{made.periods / made.realised_hz:.4g}"),
        ("B_TX / µT", _NONE if made is None else f"{1e6 * made.field_t:.4g}"),
        ("t_RX / s", f"{report.receive_s:.4g}"),
    )
    index = "specimen", [report.sample or report.variant]
    return WordedTable("How it was measured", index, tuple((heading, [cell]) for heading, cell in cells))


def _fit_quality(report: CharacterisationReport) -> WordedTable:
    """tab:fit_results_quality, with the lengths of the windows."""
    sets = (report.n50, report.d30)
    columns = (
        ("good shots", [f"{d.good} of {d.shots}" for d in sets]),
        ("T / s", [_spread(d.duration_s) for d in sets]),
        ("R² / %", [_median(d.r2, 100.0, 4) for d in sets]),
        ("least R² / %", [_NONE if d.r2 is None else f"{100.0 * d.r2.lowest:.4f}" for d in sets]),
        ("nRMSE / %", [_median(d.nrmse, 100.0, 3) for d in sets]),
        ("χ²/dof", [_median(d.chi2_per_dof, 1.0, 2) for d in sets]),
        ("time of a fit / s", [_median(d.computing_s, 1.0, 3) for d in sets]),
    )
    said = "Medians over the good shots; of T mean ± standard deviation."
    return WordedTable("How well the model fits", _windows(), columns, said)


def _parameters(report: CharacterisationReport) -> WordedTable:
    """tab:model_params_fit_result."""
    sets = (report.n50, report.d30)
    names = list(dict.fromkeys(name for d in sets for name in d.parameters))
    columns = [
        (definition_of(n).heading, [_estimate(d.parameters.get(n), definition_of(n).display_factor) for d in sets])
        for n in names
    ]
    label, unit, factor = _ORIENTATION
    angles = [_spread(d.orientation_error_rad, factor) for d in sets]
    at = 1 if columns else 0
    columns.insert(at, (f"{label} / {unit}", angles))
    said = "Mean ± standard deviation from shot to shot; the orientation error against the D30 fit with the largest R²."
    return WordedTable("Fitted parameters", _windows(), tuple(columns), said)


def _estimate(found: ParameterStatistics | None, factor: float) -> str:
    if found is None:
        return _NONE
    return f"{found.mean * factor:.4g} held" if found.fit_std is None else spread(found.mean, found.std, factor)


def _compared(report: CharacterisationReport) -> WordedTable:
    """Which means differ between the windows (ssec:primary_results)."""
    rows = report.comparisons
    shown = [_shown(row) for row in rows]
    level = f"{100.0 * (1.0 - report.alpha):g} %"
    columns = (
        ("shots", [str(row.shots) for row in rows]),
        ("N50 − D30", [_signed(row.difference, factor) for row, (_, factor) in zip(rows, shown, strict=True)]),
        (f"{level} interval", [_interval(row, factor) for row, (_, factor) in zip(rows, shown, strict=True)]),
        ("p", [_chance(row.p_value) for row in rows]),
        ("p, corrected", [_chance(row.p_adjusted) for row in rows]),
        ("significant", [_verdict(row) for row in rows]),
        ("p, signed ranks", [_chance(row.signed_rank_p_value) for row in rows]),
    )
    said = (
        "Paired t test of N50 against D30, shot by shot; corrected after Holm, so that the chance of a false yes "
        f"anywhere in the table is at most α = {report.alpha:g}."
    )
    return WordedTable("N50 against D30", ("quantity", [heading for heading, _ in shown]), columns, said)


def _shown(row: WindowComparison) -> tuple[str, float]:
    """Heading and factor from SI."""
    if row.quantity == "orientation_error_rad":
        label, unit, factor = _ORIENTATION
        return f"{label} / {unit}", factor
    return definition_of(row.quantity).heading, definition_of(row.quantity).display_factor


def _signed(value: float | None, factor: float) -> str:
    return _NONE if value is None else f"{value * factor:+.3g}"


def _interval(row: WindowComparison, factor: float) -> str:
    if row.low is None or row.high is None:
        return _NONE
    return f"{row.low * factor:+.3g} to {row.high * factor:+.3g}"


def _chance(p_value: float | None) -> str:
    return _NONE if p_value is None else f"{p_value:.2g}"


def _verdict(row: WindowComparison) -> str:
    if row.significant is None:
        return row.reason or _NONE
    return "yes" if row.significant else "no"


def _uncertainties(report: CharacterisationReport) -> WordedTable:
    """What one shot is good for."""
    rows = [(u, definition_of(u.parameter)) for u in report.uncertainties]

    def column(pick: Callable[[ParameterUncertainty], float | None]) -> list[str]:
        return [_NONE if (x := pick(u)) is None else f"{abs(x) * d.display_factor:.2g}" for u, d in rows]

    columns = (
        ("D30 mean", [f"{u.value * d.display_factor:.6g}" for u, d in rows]),
        ("scatter", column(lambda u: u.scatter)),
        ("|N50 − D30|", column(lambda u: u.window_difference)),
        ("calibration", column(lambda u: u.systematic_std)),
        ("uncertainty", column(lambda u: u.uncertainty)),
    )
    said = (
        "Standard uncertainty of one D30 fit: scatter from shot to shot, what the two windows disagree by, which a "
        "complete model would not let them, and the calibration, as far as they are known."
    )
    return WordedTable("What one shot is good for", ("parameter", [d.heading for _, d in rows]), columns, said)


def _mean_budgets(report: CharacterisationReport) -> WordedTable:
    """What the means are good for; no row without budgets."""
    rows = [(budget, definition_of(budget.quantity)) for budget in report.mean_budgets or ()]
    columns = (
        ("D30 mean", [f"{budget.value * d.display_factor:.7g}" for budget, d in rows]),
        ("U", [f"{budget.U * d.display_factor:.2g}" for budget, d in rows]),
        ("k", [f"{budget.k:.2f}" for budget, _ in rows]),
        ("largest contribution", [budget.inputs[0].name if budget.inputs else _NONE for budget, _ in rows]),
        ("largest that is not declared", [_not_declared(budget, d.display_factor) for budget, d in rows]),
    )
    said = (
        "The mean of the D30 fits lies within ± U of the quantity with a probability of 95 %, as far as its influences "
        "are declared; `platform-daemon budget` lists all of them."
    )
    return WordedTable("What the mean is good for", ("parameter", [d.heading for _, d in rows]), columns, said)


def _not_declared(budget: BudgetReport, factor: float) -> str:
    if not budget.not_declared:
        return _NONE
    found = max(budget.not_declared, key=lambda each: math.inf if (a := each.would_add_per_unit) is None else a)
    adds = found.would_add_per_unit
    return f"{found.name}: " + ("not known" if adds is None else f"{adds * factor:.2g}")


def _quality_factors(report: CharacterisationReport) -> WordedTable:
    """tab:quality_factors."""
    found = report.quality_factors
    rows = (
        ("equivalent, over N50", found.n50),
        ("equivalent, over D30", found.d30),
        ("equivalent, to the end of the motion", found.infinity),
        ("of the viscous losses alone", found.viscous),
    )
    columns = (
        ("median", [_median(q, 1.0, 0) for _, q in rows]),
        ("least", [_NONE if q is None else f"{q.lowest:.0f}" for _, q in rows]),
        ("largest", [_NONE if q is None else f"{q.highest:.0f}" for _, q in rows]),
        ("shots", ["0" if q is None else str(q.shots) for _, q in rows]),
    )
    said = "Equivalent: of a viscous damping that loses as much over that time (eq:tilde-Q)."
    return WordedTable("Quality factors", ("Q", [name for name, _ in rows]), columns, said)


def _windows() -> Column:
    return "window", list(_LABELS.values())


def _spread(found: ShotStatistics | None, factor: float = 1.0) -> str:
    return _NONE if found is None else spread(found.mean, found.std, factor)


def _median(found: ShotStatistics | None, factor: float, digits: int) -> str:
    return _NONE if found is None else f"{found.median * factor:.{digits}f}"


def held_text(dataset: FitDataset) -> str:
    """What was held, in words; "" if nothing."""
    held = ((definition_of(name), value) for name, value in dataset.held.items())
    return ", ".join(f"{d.symbol} = {value * d.display_factor:.4g} {d.display_unit}" for d, value in held)

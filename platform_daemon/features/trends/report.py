"""A trend in words and as a table."""

from __future__ import annotations

import csv
import io
import math

from rich.console import Console
from rich.table import Table

from platform_daemon.core.command_line.csv_table import text_cell
from platform_daemon.core.schemas.parameters import definition_of

from .schema import TrendChart, TrendMeasurand, TrendReport


def trend_text(report: TrendReport) -> str:
    """For the terminal: a row per quantity, then what has changed."""
    table = Table(title=f"{report.specimen}: {len(report.points)} points", title_justify="left")
    worth = any(chart.U is not None for chart in report.charts)
    for heading in ("quantity", "newest", *(("U",) if worth else ()), "at 1 temperature", "per K", "score", "chart"):
        table.add_column(heading, justify="left" if heading in ("quantity", "chart") else "right")
    for chart in report.charts:
        first, newest, *others = _row(chart)
        table.add_row(first, newest, *((_newest_u(chart),) if worth else ()), *others)
    console = Console(width=120, markup=False, highlight=False, color_system=None)  # it is printed as plain text
    with console.capture() as captured:
        console.print(table)
    lines = [captured.get().rstrip(), *_reading(report)]
    lines += [
        f"{'now' if each.stands else 'was'}: {each.name} since {each.since}: {each.what}" for each in report.changes
    ]
    if report.points and not report.changes:  # without points nothing was looked at
        lines.append("no change beyond chance")
    lines.append(f"a specimen that does not change raises an alarm once in {report.points_to_false_alarm:g} points")
    return "\n".join([*lines, *(f"note: {note}" for note in report.notes)])


def _reading(report: TrendReport) -> list[str]:
    """The newest reading, if it is a sensor."""
    told = report.measurand
    if told is None:
        return []
    for value, u in zip(reversed(told.value), reversed(told.U), strict=True):
        if value is not None and u is not None:
            line = f"{told.name}: {value:.6g} {told.unit}, U = {u:.2g} {told.unit} (95 %), by {told.calibration}"
            return [line, *_limits_read(told)]
    return [f"{told.name}: no point can be read by {told.calibration}"]


def _limits_read(told: TrendMeasurand) -> list[str]:
    """The control limits at the newest point, if the chart has any there."""
    smoothed, low, high = told.smoothed[-1], told.low[-1], told.high[-1]
    if smoothed is None or low is None or high is None:
        return []
    return [
        f"{told.name}: weighted mean of the control chart {smoothed:.6g} {told.unit}, "
        f"limits {low:.6g} to {high:.6g} {told.unit}"
    ]


def _row(chart: TrendChart) -> tuple[str, ...]:
    shown = definition_of(chart.quantity)
    value, corrected = _last(chart.value), _last(chart.corrected)
    coefficient = (
        "" if chart.relative_per_k is None else f"{chart.relative_per_k:+.2e} ± {chart.relative_per_k_std:.0e}"
    )
    ewma, limit = _last(chart.ewma), _last(chart.limit)
    state = "learning" if ewma is None or limit is None else "outside" if abs(ewma) > limit else "inside"
    return (
        shown.heading,
        _number(value, shown.display_factor),
        _number(corrected, shown.display_factor),
        coefficient,
        "" if (score := _last(chart.score)) is None else f"{score:+.1f}",
        state,
    )


def _newest_u(chart: TrendChart) -> str:
    u = None if chart.U is None else _last(chart.U)
    return "" if u is None else f"{u * definition_of(chart.quantity).display_factor:.2g}"


def _last(values: tuple[float | None, ...]) -> float | None:
    return next((v for v in reversed(values) if v is not None and math.isfinite(v)), None)


def _number(value: float | None, factor: float) -> str:
    return "" if value is None else f"{value * factor:.7g}"


def trend_csv(report: TrendReport) -> str:
    """A row per point: when, recording, shots, temperature, each quantity as measured and at one temperature, with U
    where it was asked for, what a sensor reads with U, then the clock of its time."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = {
        name: values
        for chart in report.charts
        for name, values in (
            (chart.quantity, chart.value),
            (f"{chart.quantity}_corrected", chart.corrected),
            (f"{chart.quantity}_U", chart.U),
        )
        if values is not None
    }
    if (told := report.measurand) is not None:
        columns[f"{told.name} [{told.unit}]"], columns[f"U of {told.name} [{told.unit}]"] = told.value, told.U
        columns |= {f"{key} of {told.name} [{told.unit}]": getattr(told, key) for key in ("smoothed", "low", "high")}
    writer.writerow(["at", "recording", "shots", "temperature_c", *map(text_cell, columns), "clock"])
    for k, point in enumerate(report.points):
        values = [column[k] for column in columns.values()]
        cells = ["" if v is None or not math.isfinite(v) else repr(v) for v in (point.temperature_c, *values)]
        writer.writerow([point.at, text_cell(point.recording), point.shots, *cells, point.clock or ""])
    return text.getvalue()

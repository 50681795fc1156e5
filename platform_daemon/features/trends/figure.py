"""Picture of a trend: each quantity over the months, with its control chart on the right."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num
from matplotlib.figure import Figure
from numpy.typing import NDArray

from platform_daemon.core.reporting.figures import COLOURS, as_written, new_figure, png_of, save_figure
from platform_daemon.core.schemas.parameters import definition_of

from .schema import TrendChart, TrendMeasurand, TrendReport

_ROW_INCHES = 1.5


def trend_png(report: TrendReport) -> bytes:
    """The picture as PNG."""
    return png_of(draw_trend(report), 110)


def save_trend_png(report: TrendReport, path: Path) -> None:
    """Write it; the file appears whole or not at all."""
    save_figure(draw_trend(report), path)


def draw_trend(report: TrendReport) -> Figure:
    """A row per quantity: left its values, grey as measured, and at one temperature; right the chart and its limits.

    Of a specimen that is calibrated as a sensor the first row is what it reads, in the unit of its measurand: left with
    U, right the weighted mean of the chart of its frequency between its limits.  Dashed: since when something has
    changed, with its name where it was noticed.
    """
    above = 0 if report.measurand is None else 1
    rows = max(len(report.charts), 1) + above
    figure = new_figure(11, _ROW_INCHES * rows + 1.0)
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False, width_ratios=(3, 2))
    times = np.array([_day(point.at) for point in report.points])
    shots = sum(point.shots for point in report.points)
    figure.suptitle(f"{as_written(report.specimen)}: {shots} shots", fontsize=11)
    if report.measurand is not None:
        _readings(panels[0], times, report.measurand)
    for (left, right), chart in zip(panels[above:], report.charts, strict=False):
        _values(left, times, chart)
        _chart(right, times, chart)
        _changes((left, right), report, chart)
    panels[above, 0].legend(fontsize=7, loc="upper left", ncols=2)
    panels[above, 1].set_title("control chart over its limit", fontsize=9)
    locator = AutoDateLocator()
    panels[-1, 0].xaxis.set_major_locator(locator)
    panels[-1, 0].xaxis.set_major_formatter(ConciseDateFormatter(locator))
    if any(point.clock == "simulated" for point in report.points):
        panels[-1, 0].set_xlabel("simulated time", fontsize=8)
    return figure


def _readings(panels: NDArray[np.object_], times: NDArray[np.float64], told: TrendMeasurand) -> None:
    """What a sensor reads; points that cannot be read are missing."""
    left, right = panels
    value, expanded, mean, low, high = (
        np.array(column, dtype=float) for column in (told.value, told.U, told.smoothed, told.low, told.high)
    )
    left.errorbar(times, value, expanded, fmt=".", ms=2.5, lw=0.6, color=COLOURS[0])
    left.set_title(as_written(f"{told.name} by {told.calibration}, with U (95 %)"), fontsize=9)
    left.set_ylabel(as_written(f"{told.name} / {told.unit}"), fontsize=8)
    right.fill_between(times, low, high, color="0.92", lw=0)
    right.plot(times, mean, lw=1.0, color=COLOURS[0])
    outside = (mean < low) | (mean > high)
    right.plot(times, np.where(outside, mean, np.nan), lw=1.6, color=COLOURS[1])
    right.set_title(as_written(f"weighted mean and limits / {told.unit}"), fontsize=9)
    for axes in panels:
        axes.ticklabel_format(axis="y", useOffset=False)
        axes.tick_params(labelsize=7)


def _values(axes: Axes, times: NDArray[np.float64], chart: TrendChart) -> None:
    shown = definition_of(chart.quantity)
    raw, corrected = (np.array(v, dtype=float) * shown.display_factor for v in (chart.value, chart.corrected))
    axes.plot(times, raw, ".", ms=2.5, color="0.75", label="as measured")
    label = "" if chart.reference_c is None else f"at {chart.reference_c:.1f} °C"
    if label:
        axes.plot(times, corrected, ".", ms=2.5, color=COLOURS[0], label=label)
    axes.set_ylabel(_label(chart.quantity), fontsize=8)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.tick_params(labelsize=7)


def _chart(axes: Axes, times: NDArray[np.float64], chart: TrendChart) -> None:
    with np.errstate(invalid="ignore"):
        ratio = np.array(chart.ewma, dtype=float) / np.array(chart.limit, dtype=float)
    axes.axhspan(-1.0, 1.0, color="0.92", lw=0)
    axes.plot(times, ratio, lw=1.0, color=COLOURS[0])
    axes.plot(times, np.where(np.abs(ratio) > 1.0, ratio, np.nan), lw=1.6, color=COLOURS[1])
    axes.set_ylim(*(np.array([-1.3, 1.3]) if not np.any(np.abs(ratio) > 1.2) else (-4.5, 4.5)))
    axes.tick_params(labelsize=7)


def _changes(panels: tuple[Axes, Axes], report: TrendReport, chart: TrendChart) -> None:
    for change in report.changes:
        if chart.quantity not in change.quantities:
            continue
        for axes in panels:
            axes.axvline(_day(change.since), color=COLOURS[1], ls="--", lw=0.9)
        name = change.name.replace("_", " ")
        at = (_day(change.noticed), 0.93)
        panels[1].annotate(name, at, xycoords=("data", "axes fraction"), va="top", fontsize=7, color=COLOURS[1])


def _label(quantity: str) -> str:
    """As people read it; noise_CHANNEL_v and nrmse are no parameters."""
    if quantity.startswith("noise_"):
        return f"noise of {as_written(quantity.removeprefix('noise_').removesuffix('_v'))} / V"
    return "nRMSE" if quantity == "nrmse" else definition_of(quantity).axis_label


def _day(text: str) -> float:
    """As matplotlib counts."""
    return float(date2num(datetime.fromisoformat(text)))

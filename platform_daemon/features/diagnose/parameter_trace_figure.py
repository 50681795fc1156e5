"""Picture of a constant that moves along the ring-down: against time, amplitude and peak speed."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from platform_daemon.core.reporting.figures import AFTER, BEFORE, new_figure
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.diagnosis.report_schema import MeanParameter, MovingParameter, ParameterTrace

_PANELS = (
    ("time", "time_s", "time / s", 1.0),
    ("amplitude", "amplitude_rad", "amplitude / °", math.degrees(1.0)),
    ("speed", "peak_speed_rad_per_s", "peak speed / rad s⁻¹", 1.0),
)


def draw_trace(moved: MovingParameter, constant: MeanParameter | None) -> Figure:
    """The trace with two standard deviations; red: the constant of the declared model.

    The quantity that it follows best, and those that it follows hardly worse, have a thick frame.
    """
    shown = definition_of(moved.name)
    figure = new_figure(11, 2.7)
    panels = figure.subplots(1, len(_PANELS), sharey=True)
    for axes, (name, key, label, factor) in zip(panels, _PANELS, strict=True):
        for trace in moved.traces:
            _one(axes, trace, np.array(getattr(trace, key), float) * factor, shown.display_factor)
        if constant is not None and constant.value is not None:
            axes.axhline(constant.value * shown.display_factor, color=BEFORE, lw=0.9)
        axes.set_xlabel(label, fontsize=9)
        axes.ticklabel_format(axis="y", useOffset=False)
        axes.tick_params(labelsize=8)
        if name in moved.follows:
            for side in axes.spines.values():
                side.set_linewidth(2.2)
    panels[0].set_ylabel(shown.axis_label, fontsize=9)
    return figure


def _one(axes: Axes, trace: ParameterTrace, x: np.ndarray, factor: float) -> None:
    order = np.argsort(x)
    value, std = (np.array(v, float)[order] * factor for v in (trace.value, trace.std))
    axes.fill_between(x[order], value - 2.0 * std, value + 2.0 * std, color=AFTER, alpha=0.25, lw=0)
    axes.plot(x[order], value, "o-", ms=2.5, lw=1.1, color=AFTER)

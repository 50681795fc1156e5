"""The picture of sliding-window fits: what a complete model keeps constant, window by window, with errors."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from platform_daemon.core.reporting.figures import COLOURS, as_written, save_figure
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.estimation.sliding_window import SlidingFit

from .sliding import amplitude_course


def save_sliding_png(found: SlidingFit, title: str, path: Path) -> None:
    """Write the picture as PNG; the file appears whole or not at all."""
    save_figure(draw_sliding(found, title), path)


def draw_sliding(found: SlidingFit, title: str) -> Figure:
    """A panel per constant that was fitted, with its weighted mean; phi_max; grey where a window was refused."""
    names = [n for n in found.constants if found.course(n)[0].size]
    figure = Figure(figsize=(10, 1.9 * (len(names) + 1) + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(names) + 1, 1, sharex=True, squeeze=False)[:, 0]
    step = "" if found.step_s == found.window_s else f", every {found.step_s:.3g} s"
    title = as_written(f"{title}\nwindows of {found.window_s:.3g} s{step}; grey: refused")
    figure.suptitle(title, fontsize=11)
    for axes, name in zip(panels, names, strict=False):
        _constant(axes, found, name)
    _amplitude(panels[-1], found)
    for axes in panels:
        for window in found.windows:
            if window.fit.verdict != "good":
                axes.axvspan(window.start_s, window.end_s, color="0.85", lw=0)
    return figure


def _constant(axes: Axes, found: SlidingFit, name: str) -> None:
    shown = definition_of(name)
    factor = shown.display_factor
    time, value, sd = found.course(name)
    axes.errorbar(time, value * factor, sd * factor, fmt="o", ms=3, capsize=2, lw=0.9, color=COLOURS[0])
    axes.set_ylabel(shown.axis_label)
    axes.ticklabel_format(axis="y", useOffset=False)
    flat = found.flatness(name)
    if flat is not None:
        axes.axhline(flat.mean * factor, color=COLOURS[1], lw=0.9)
        slope = flat.slope_per_s / flat.slope_sd
        text = f"χ²/dof {flat.chi2_per_dof:.2f} (p = {flat.probability:.2g}), slope {slope:+.1f} sd"
        axes.annotate(text, (0.01, 0.95), xycoords="axes fraction", va="top", fontsize=8)


def _amplitude(axes: Axes, found: SlidingFit) -> None:
    time, value, sd = amplitude_course(found)
    axes.errorbar(time, value, sd, fmt="o", ms=3, capsize=2, lw=0.9, color=COLOURS[2])
    axes.set(ylabel="$φ_{max}$ / °\nat the window's start", xlabel="time after the first RX sample / s (window centre)")

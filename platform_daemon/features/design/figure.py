"""Picture of a manufacturing defect like the paper's figures: its perpendicular force over its size."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from platform_daemon.core.reporting.figures import png_of, save_figure

from .curves import ForceCurves

_WORDS = {"stator_tilt": "tilted stator", "rotor_tilt": "tilted rotor", "jewel_tilt": "tilted jewel",
          "lateral": "lateral displacement"}  # fmt: skip
_MOST_LINES = 8


def save_defects_png(curves: ForceCurves, path: Path) -> None:
    """Write the picture as PNG; the file appears whole or not at all."""
    save_figure(draw_defects(curves), path)


def defects_png(curves: ForceCurves) -> bytes:
    """The picture as PNG."""
    return png_of(draw_defects(curves), 110)


def draw_defects(curves: ForceCurves) -> Figure:
    """Left: at the requested deflections, lines or a map; right: for other cups or threads.  Dotted: gravity."""
    request = curves.defect.request
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    name = "R" if request.bearing == "jewel" else "l"
    figure.suptitle(f"{request.bearing} bearing, {_WORDS[request.defect]}", fontsize=11)
    if curves.phi_deg.size > _MOST_LINES:
        _map(figure, left, curves)
    else:
        labels = [f"φ = {phi:g}°" for phi in curves.phi_deg]
        draw_force_lines(left, curves, curves.force_n, labels)
    left.set_title(f"${name}$ = {_ratio(curves.defect.span_over_r)}", fontsize=10)
    draw_force_lines(right, curves, curves.family_force_n, [f"${name}$ = {_ratio(s)}" for s in curves.spans_over_r])
    right.set_title(f"φ = {curves.family_phi_deg:g}°", fontsize=10)
    for axes in (left, right):
        axes.set_xlabel("Δy / mm" if request.defect == "lateral" else "ε / °")
    return figure


def _ratio(value: float) -> str:
    return f"{value:.3g} $r$" if math.isfinite(value) else "∞"


def draw_force_lines(
    axes: Axes,
    curves: ForceCurves,
    force: NDArray[np.float64],
    labels: list[str],
    style: str = "-",
    *,
    weight: bool = True,
) -> None:
    """Forces (n, k), N, over the size of the defect, and dotted the rotor's weight; a label "" is left out."""
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, len(labels)))
    for k, (label, colour) in enumerate(zip(labels, colours, strict=True)):
        axes.plot(curves.size, force[:, k] * 1e3, style, color=colour, lw=1.3, label=label or None)
    if weight:
        axes.axhline(curves.weight_n * 1e3, label="gravity", color="0.5", ls=":", lw=1.0)
    axes.set_xlim(0, curves.size[-1])
    axes.set_ylim(bottom=0)
    axes.set_ylabel("$\\tilde{F}_\\perp$ / mN")
    axes.legend(fontsize=8)


def _map(figure: Figure, axes: Axes, curves: ForceCurves) -> None:
    mesh = axes.pcolormesh(curves.size, curves.phi_deg, curves.force_n.T * 1e3, shading="gouraud", cmap="viridis")
    figure.colorbar(mesh, ax=axes, label="$\\tilde{F}_\\perp$ / mN")
    known = np.nan_to_num(curves.force_n.T * 1e3)
    if known.min() < curves.weight_n * 1e3 < known.max():
        axes.contour(curves.size, curves.phi_deg, known, [curves.weight_n * 1e3], colors="w", linestyles=":")
    axes.set_ylabel("φ / ° (dotted: as large as gravity)")

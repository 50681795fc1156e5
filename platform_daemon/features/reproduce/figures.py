"""The paper's figures that need no measurement: friction in a cup, perpendicular forces, and positions of rest."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from platform_daemon.core.reporting.figures import COLOURS, new_figure
from platform_daemon.design.equations import PAPER_JEWEL, PAPER_MAGNETS, friction_increase
from platform_daemon.features.characterise.side_by_side.folder import NamedFigure
from platform_daemon.features.design.checked_defect import checked_defect
from platform_daemon.features.design.curves import ForceCurves, force_curves
from platform_daemon.features.design.figure import draw_force_lines
from platform_daemon.features.design.schema import DefectsRequest

_DEFECTS = {
    "F_tan_over_epsilon": ("stator_tilt", "stator_tilt"),
    "F_tan_over_rotor_epsilon": ("jewel_tilt", "rotor_tilt"),
    "F_tan_over_delta_y": ("lateral", "lateral"),
}  # of the jewel and of the thread, by the paper's label
_LARGEST_DEG, _LARGEST_MM, _DEFLECTIONS_DEG = 10.0, 1.0, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]
_WORDS = {"stator_tilt": "tilted stator", "rotor_tilt": "tilted rotor", "jewel_tilt": "tilted jewel",
          "lateral": "lateral displacement"}  # fmt: skip


def design_figures() -> Iterator[NamedFigure]:
    """Those that need no measurement, in the order of the paper."""
    caption = "fig:simulation_lambda(t): friction in a cup over that of a flat jewel"
    yield NamedFigure("simulation_lambda", caption, _friction())
    for name, (jewel, thread) in _DEFECTS.items():
        caption = f"fig:{name}: perpendicular force, jewel: {_WORDS[jewel]}, thread: {_WORDS[thread]}"
        yield NamedFigure(name, caption, _forces(jewel, thread))
    caption = "fig:equilibrium_positions_defects: rest of the rotor at 10° of tilt, or 1 mm of displacement"
    yield NamedFigure("equilibrium_positions_defects", caption, _positions_of_rest())


def _friction() -> Figure:
    figure = new_figure(6, 3.4)
    axes = figure.subplots()
    ratio = np.linspace(1.1, 10.0, 200)
    axes.plot(ratio, [friction_increase(float(k)) for k in ratio], color=COLOURS[0])
    own = PAPER_JEWEL.cup_radius_m / PAPER_MAGNETS.radius_m
    axes.plot([own], [friction_increase(own)], "o", color=COLOURS[2], label=f"R/r = {own:.3g}")
    axes.set(xlabel="R / r", ylabel="Λ", xlim=(1.0, 10.0))
    axes.legend(fontsize=8)
    return figure


def _curves(bearing: str, defect: str) -> ForceCurves:
    keys: dict[str, object] = {"bearing": bearing, "defect": defect, "phi_deg": _DEFLECTIONS_DEG}
    keys |= {"dy_mm": [_LARGEST_MM]} if defect == "lateral" else {"eps_deg": [_LARGEST_DEG]}
    return force_curves(checked_defect(DefectsRequest.model_validate(keys)))


def _forces(jewel: str, thread: str) -> Figure:
    """(a) over deflections, solid the jewel and dashed the thread; (b) cups; (c) threads."""
    figure = new_figure(12, 3.8)
    first, cups, threads = figure.subplots(1, 3)
    for bearing, defect, axes, style in (("jewel", jewel, cups, "-"), ("thread", thread, threads, "--")):
        curves, symbol = _curves(bearing, defect), "R" if bearing == "jewel" else "l"
        labels = [f"φ = {phi:g}°" if bearing == "jewel" else "" for phi in curves.phi_deg]
        draw_force_lines(first, curves, curves.force_n, labels, style, weight=bearing == "jewel")
        spans = [f"{symbol} = {s:.3g} r" if math.isfinite(s) else f"{symbol} = ∞" for s in curves.spans_over_r]
        draw_force_lines(axes, curves, curves.family_force_n, spans)
        axes.set_title(f"{bearing}, φ = {curves.family_phi_deg:g}°", fontsize=10)
    first.set_title("jewel, R = 5/3 r; dashed: thread, l = 8 r", fontsize=10)
    first.autoscale(axis="y")
    first.set_ylim(bottom=0)
    for axes in (first, cups, threads):
        axes.set_xlabel("Δy / mm" if jewel == "lateral" else "ε / °")
    return figure


def _positions_of_rest() -> Figure:
    """The six defects in the plane of the magnetisation (y) and the axis of the bearing (z)."""
    figure = new_figure(9, 8)
    cases = [("thread", d) for d in ("stator_tilt", "rotor_tilt", "lateral")]
    cases += [("jewel", d) for d in ("stator_tilt", "jewel_tilt", "lateral")]
    for axes, (bearing, defect) in zip(figure.subplots(2, 3).flat, cases, strict=True):
        _draw_rest(axes, bearing, defect)
    return figure


def _draw_rest(axes: Axes, bearing: str, defect: str) -> None:
    lateral, r, d = defect == "lateral", 1e3 * PAPER_MAGNETS.radius_m, 1e3 * PAPER_MAGNETS.distance_m
    size = _LARGEST_MM if lateral else _LARGEST_DEG
    keys: dict[str, object] = {"bearing": bearing, "defect": defect, "phi_deg": [0.0]}
    keys["dy_mm" if lateral else "eps_deg"] = [size]
    rest = checked_defect(DefectsRequest.model_validate(keys)).analysed([size], [0.0])
    centre, moment, axis = 1e3 * rest.centre_m[0, 1:], rest.moment[0, 1:], rest.axis[0, 1:]
    tilt = math.radians(size) if defect == "stator_tilt" else 0.0
    stator = np.array([size if lateral else 0.0, 0.0])
    for place, direction, colour in (
        (stator, np.array([math.cos(tilt), math.sin(tilt)]), "0.4"),
        (np.array([0.0, d]), np.array([-1.0, 0.0]), "#f2b8bd"),
        (centre, moment, COLOURS[1]),
    ):
        axes.add_patch(Circle((place[0], place[1]), r, fill=False, color=colour))
        tail, head = place - 0.8 * r * direction, place + 0.8 * r * direction
        axes.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]),
                      arrowprops={"arrowstyle": "->", "color": colour})  # fmt: skip
    ends = centre - 2.0 * r * axis, centre + 2.5 * r * axis
    axes.plot(*np.transpose(ends), "-.", lw=0.9, color="k")
    axes.axvline(0.0, lw=0.6, color="0.7", zorder=0)
    axes.set(aspect="equal", xlim=(-4.0, 4.0), ylim=(-2.2, 9.5), xlabel="y / mm", ylabel="z / mm")
    shift, alpha = 1e3 * rest.displacement_m[0], math.degrees(rest.alpha_rad[0])
    title = f"{bearing}: {_WORDS[defect]}\n|Δy$_C$| = {shift:.3f} mm, α = {alpha:.2f}°"
    axes.set_title(title, fontsize=9)

"""Picture of a ramp: z residual and deflection against the field, the threshold and the field to work at."""

from __future__ import annotations

import math
from pathlib import Path

from matplotlib.figure import Figure

from platform_daemon.schemas import RampOutcome

from .diagnosis import AFTER, BEFORE, new_figure
from .ring_down import save_figure

_MARKS = {"below": "o", "suspected": "s", "visible": "D"}


def save_ramp_png(found: RampOutcome, path: Path) -> None:
    """Write it to a file."""
    save_figure(draw_ramp(found), path)


def draw_ramp(found: RampOutcome) -> Figure:
    """Above the z residual of every field, with the visible level; below the deflection."""
    figure = new_figure(7, 5.5)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for verdict, mark in _MARKS.items():
        steps = [s for s in found.steps if s.verdict == verdict]
        fields = [1e6 * s.field_t for s in steps]
        upper.plot(fields, [s.z_residual_am2_per_s for s in steps], mark, ms=4, color=AFTER, label=verdict)
        swung = [s for s in steps if s.phi_max_rad is not None]
        angles = [math.degrees(s.phi_max_rad or 0.0) for s in swung]
        lower.plot([1e6 * s.field_t for s in swung], angles, mark, ms=4, color=AFTER)
    upper.axhline(found.visible_am2_per_s, color=BEFORE, lw=0.9)
    if found.threshold_t is not None:
        t = found.threshold_t
        top = 1e6 * min(t.high, found.steps[-1].field_t * 1.1)
        for axes in (upper, lower):
            axes.axvspan(1e6 * t.low, top, color=BEFORE, alpha=0.15, lw=0)
            axes.axvline(1e6 * t.value, color=BEFORE, lw=0.9)
    if found.operating_field_t is not None:
        for axes in (upper, lower):
            axes.axvline(1e6 * found.operating_field_t, color="0.4", lw=0.9, ls="--")
    upper.set_ylabel("z residual / A m² s⁻¹")
    lower.set_ylabel("φ_max / °")
    lower.set_xlabel("field / µT (dashed: to work at; red: threshold, 95 %)")
    upper.legend(loc="upper left", frameon=False)
    return figure

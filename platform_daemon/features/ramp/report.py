"""A ramp for the terminal and as a picture."""

from __future__ import annotations

import math
from pathlib import Path

from matplotlib.figure import Figure

from platform_daemon.core.reporting.figures import AFTER, BEFORE, new_figure, save_figure
from platform_daemon.core.reporting.tables import Column, tables_text

from .schema import RAMP_ENDS, RampOutcome, RampPrediction


def ramp_text(found: RampOutcome) -> str:
    """A row per field; then threshold, field to work at, and what the z residual is made of."""
    steps = ("field / uT", [f"{1e6 * s.field_t:.5g}" for s in found.steps])
    columns: list[Column] = [
        ("shots", [str(s.shots) for s in found.steps]),
        ("φ_max / °", ["-" if s.phi_max_rad is None else f"{math.degrees(s.phi_max_rad):.2f}" for s in found.steps]),
        ("z / A m² s⁻¹", [f"{s.z_residual_am2_per_s:.3f}" for s in found.steps]),
        ("lg e", [f"{s.statistic:.2f}" for s in found.steps]),
        ("side modes", [s.verdict for s in found.steps]),
    ]
    return "\n".join([tables_text("ramp", steps, columns), *_said(found)])


def _said(found: RampOutcome) -> list[str]:
    t = found.threshold_t
    said = (
        _no_threshold(found)
        if t is None
        else f"side modes pass {found.visible_am2_per_s:g} A m²/s at {1e6 * t.value:.4g} uT "
        f"(95 %: {1e6 * t.low:.4g} to {1e6 * t.high:.4g} uT)"
    )
    lines = ", ".join(f"{x.frequency_hz:.1f} Hz ({x.near}, {x.size_am2_per_s:.3f} A m²/s)" for x in found.lines)
    return [
        said,
        *([] if found.predicted is None else [_predicted(found.predicted)]),
        *([] if found.operating_field_t is None else [f"work at {1e6 * found.operating_field_t:.4g} uT"]),
        *([f"in z at the highest field: {lines}"] if lines else []),
        *(["the drive saturates: the deflection hardly grows with the field"] if found.drive_saturated else []),
        f"chance of a false stop {found.false_stop_rate:g}, of a step above the threshold {found.overdose_rate:g} each",
        *([] if found.specimen_file is None else [f"kept with the specimen: {found.specimen_file}"]),
    ]


def _predicted(found: RampPrediction) -> str:
    if found.why is not None:
        return f"{found.model} predicts no threshold: {found.why}"
    if found.threshold_t is None:
        return f"{found.model} predicts none up to {1e6 * (found.highest_field_t or 0.0):.4g} uT"
    return f"{found.model} predicts {1e6 * found.threshold_t:.4g} uT"


def _no_threshold(found: RampOutcome) -> str:
    if [step.verdict for step in found.steps] == ["visible"]:
        return "side modes show at the first field already: start lower"
    highest = 1e6 * (found.highest_field_t or found.steps[-1].field_t)
    end = "" if found.ended_by is None else f" ({RAMP_ENDS[found.ended_by]})"
    return f"no threshold was found up to {highest:.4g} uT{end}: no field is proposed, and nothing is kept"


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

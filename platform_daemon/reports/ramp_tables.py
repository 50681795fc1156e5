"""A ramp for the terminal."""

from __future__ import annotations

import math

from platform_daemon.schemas import RampOutcome

from .fit_tables import Column, tables_text


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
    above = [step.verdict for step in found.steps] == ["visible"]
    said = (
        ("side modes show at the first field already: start lower" if above else "no threshold was reached")
        if t is None
        else f"side modes pass {found.visible_am2_per_s:g} A m²/s at {1e6 * t.value:.4g} uT "
        f"(95 %: {1e6 * t.low:.4g} to {1e6 * t.high:.4g} uT)"
    )
    lines = ", ".join(f"{x.frequency_hz:.1f} Hz ({x.near}, {x.size_am2_per_s:.3f} A m²/s)" for x in found.lines)
    return [
        said,
        *([] if found.operating_field_t is None else [f"work at {1e6 * found.operating_field_t:.4g} uT"]),
        *([f"in z at the highest field: {lines}"] if lines else []),
        *(["the drive saturates: the deflection hardly grows with the field"] if found.drive_saturated else []),
        f"chance of a false stop {found.false_stop_rate:g}, of a step above the threshold {found.overdose_rate:g} each",
        *([] if found.specimen_file is None else [f"kept with the specimen: {found.specimen_file}"]),
    ]

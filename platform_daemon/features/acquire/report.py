"""A series as it would be, for the terminal."""

from __future__ import annotations

import math

from platform_daemon.core.reporting.tables import Column, tables_text
from platform_daemon.core.schemas.acquisitions import AcquisitionSummary, ShotSummary
from platform_daemon.core.schemas.text import counted
from platform_daemon.core.schemas.value_sources import value_sources_text


def dry_run_text(plan: AcquisitionSummary) -> str:
    """A row per kind of shot with peaks, I2t, energy and windows, then duration, disk and warnings."""
    shots = plan.shots_in_turn or (plan.shot,)
    numbers = ("shot", [str(k) for k in range(1, len(shots) + 1)] if plan.shots_in_turn else ["each"])
    notes = [f"warning: {text}" for text in plan.warnings]
    if plan.shot.planned_phi_max_rad is not None:
        notes.insert(0, f"the model reaches {math.degrees(plan.shot.planned_phi_max_rad):.1f} degrees")
    total = f"{counted(plan.shots, 'shot')}, {plan.duration_s:.4g} s, {plan.disk_bytes / 1e6:.3g} MB"
    sources = value_sources_text(plan.value_sources or ())
    return "\n".join([tables_text(plan.resonator, numbers, _columns(shots)), sources, total, *notes])


def _columns(shots: tuple[ShotSummary, ...]) -> list[Column]:
    return [
        ("f_TX / Hz", [f"{s.f_tx_realised_hz:.2f}" for s in shots]),
        ("t_TX / ms", [f"{1e3 * s.t_tx_s:.4g}" for s in shots]),
        ("peak B / µT", [f"{1e6 * s.peak_field_t:.4g}" for s in shots]),
        ("peak I / A", [_by_coil(s.peak_current_a) for s in shots]),
        ("peak U / V", [_by_coil(s.peak_amplifier_v) for s in shots]),
        ("I²t / A²s", [_by_coil(s.i2t_a2s) for s in shots]),
        ("energy / mJ", [f"{1e3 * s.energy_j:.4g}" for s in shots]),
        ("duration / s", [f"{s.duration_s:.4g}" for s in shots]),
    ]


def _by_coil(values: dict[str, float]) -> str:
    return " ".join(f"{axis} {value:.3g}" for axis, value in values.items())

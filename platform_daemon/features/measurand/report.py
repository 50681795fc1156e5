"""Calibrations and readings of measurands in words."""

from __future__ import annotations

from platform_daemon.core.reporting.tables import Column, tables_text
from platform_daemon.core.schemas.text import counted

from .schema import MeasurandCalibration, MeasurandReading, MeasurandReport, ResidualTest


def calibration_text(made: MeasurandCalibration) -> str:
    """A paragraph of what was found."""
    lines = [
        f"{made.label}: {made.name} of {made.specimen}, {made.valid_from:g} to {made.valid_to:g} {made.unit}",
        f"{counted(made.pairs, 'shot')} with a reading of the reference, {made.dropped} without",
        f"resolution of one shot: {made.resolution:.3g} {made.unit} (scatter of {1e3 * made.scatter_hz:.3g} mHz)",
    ]
    if made.lag_s is not None:
        lines.append(f"the resonator follows the reference after {made.lag_s:.4g} s (u = {made.lag_std_s:.2g} s)")
    lines.append(_tested("hysteresis", made.hysteresis_hz, 1e3, "mHz"))
    lines.append(_tested("drift", made.drift_hz_per_day, 1e3, "mHz per day"))
    if made.by_temperature_hz_per_k is not None:
        lines.append(_tested("temperature", made.by_temperature_hz_per_k, 1e3, "mHz/K"))
    checked = made.cross_validation
    lines.append(
        f"cross-validation: {checked.rms:.3g} {made.unit} rms, {checked.covered:.0%} of {checked.readings} readings "
        "within U (95%)"
    )
    return "\n".join([*lines, *(f"note: {note}" for note in made.notes)])


def _tested(name: str, test: ResidualTest, factor: float, unit: str) -> str:
    said = "significant: a line of every budget" if test.significant else "none"
    return f"{name}: {said} ({factor * test.value:.2g} {unit}, u = {factor * test.u:.2g}, p = {test.probability:.2g})"


def readings_text(report: MeasurandReport) -> str:
    """A line for each shot, the mean, and what was refused."""
    rows = [*report.shots, *([report.mean] if report.mean is not None else [])]
    index = ("shot", [_name(each) for each in rows])
    columns: list[Column] = [
        (f"{report.name} / {report.unit}", [f"{each.value:.6g}" for each in rows]),
        (f"U / {report.unit}", [f"{each.U:.2g}" for each in rows]),
        ("k", [f"{each.k:.2f}" for each in rows]),
        ("largest contribution", [each.inputs[0].name for each in rows]),
    ]
    lines = [f"{report.file}: {report.name} by {report.calibration}"]
    if rows:
        lines = [tables_text(lines[0], index, columns, last_apart=report.mean is not None)]
    lines += [f"refused: shot {each.frame}: {each.reason}" for each in report.refused]
    lines += [] if report.mean_reason is None else [f"no mean: {report.mean_reason}"]
    lines += [f"not declared: {each}" for each in report.not_declared]
    return "\n".join(lines)


def _name(each: MeasurandReading) -> str:
    mark = " (extrapolated)" if each.extrapolated else ""
    return f"mean{mark}" if len(each.frames) > 1 else f"{each.frames[0]}{mark}"

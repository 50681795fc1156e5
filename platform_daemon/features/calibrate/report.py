"""What a calibration has found, as a table for the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from platform_daemon.core.reporting.numbers import number
from platform_daemon.core.schemas.calibrations import ReceiveCalibrationReport, TransmitCalibrationReport


def print_calibration(report: ReceiveCalibrationReport | TransmitCalibrationReport) -> None:
    """Sensitivity by channel, or field and inductance by coil."""
    table = _receive_table(report) if isinstance(report, ReceiveCalibrationReport) else _transmit_table(report)
    Console(width=120).print(table)


def _table(title: str, *headings: str) -> Table:
    table = Table(title=title, title_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right")
    return table


def _receive_table(report: ReceiveCalibrationReport) -> Table:
    table = _table(f"{report.calibration}: sensitivity / mT A⁻¹", "channel", "x", "y", "z")
    rows = zip(report.sensitivity_t_per_a, report.sensitivity_std_t_per_a, strict=True)
    for channel, (values, stds) in enumerate(rows):
        table.add_row(str(channel), *(number(v, s, 1e3) for v, s in zip(values, stds, strict=True)))
    return table


def _transmit_table(report: TransmitCalibrationReport) -> Table:
    table = _table(report.calibration, "coil", "field / mT A⁻¹ (x, y, z)", "L / mH", "χ²/dof")
    rows = zip(report.coils, report.field_t_per_a, report.inductance_h, report.chi2_per_dof, strict=True)
    for coil, field, henry, chi2 in rows:
        table.add_row(coil, ", ".join(f"{1e3 * b:.5f}" for b in field), f"{1e3 * henry:.4f}", f"{chi2:.2f}")
    return table

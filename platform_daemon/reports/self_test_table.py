"""What a self-test has heard, as a table for the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from platform_daemon.schemas import SelfTestReport


def print_self_test(report: SelfTestReport) -> None:
    """Gain and isolation by coil."""
    table = Table(title=f"self-test passed, tones of {report.frequency_hz:.0f} Hz", title_justify="left")
    for heading in ("coil", "gain / expected", "isolation / dB"):
        table.add_column(heading, justify="right")
    for coil, gain in report.gain.items():
        table.add_row(coil, f"{gain:.3f}", f"{report.isolation_db[coil]:.1f}")
    Console(width=120).print(table)

"""The devices of a platform, and what was found about it, as tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from platform_daemon.core.schemas.control_characters import printable
from platform_daemon.core.schemas.platform import DeviceReport
from platform_daemon.core.schemas.unattended import Checkup


def print_devices(reports: Sequence[DeviceReport]) -> None:
    """A row per device: who it is, its state, and what went wrong."""
    table = Table()
    for heading in ("device", "identity", "state", "error"):
        table.add_column(heading, overflow="fold")
    for report in reports:
        identity = " ".join(part for _, part in report.identity or () if part)
        state = ", ".join(f"{name} {_plain(value)}" for name, value in report.state)
        table.add_row(*map(printable, (report.device, identity or "-", state or "-", report.error or "-")))
    Console(markup=False).print(table)


def print_findings(found: Checkup) -> None:
    """A row per check: its verdict, what was found, and what to do."""
    table = Table()
    for heading in ("check", "verdict", "found", "remedy"):
        table.add_column(heading, overflow="fold")
    for each in found.findings:
        table.add_row(*map(printable, (each.check, each.verdict, each.found, each.remedy or "-")))
    Console(markup=False).print(table)


def _plain(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

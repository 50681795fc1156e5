"""`platform-daemon doctor`: what would keep this computer from running unattended."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.core.command_line.options import (
    EndpointsOption,
    ForceOption,
    JsonOption,
    PlatformOption,
    SetOption,
)
from platform_daemon.core.command_line.output import must_not_exist, write_json

PortOption = Annotated[int, typer.Option(help="Port of the daemon; the next one only stops.", min=1, max=65534)]


def doctor(
    platform: PlatformOption = "lab",
    data: Annotated[Path, typer.Option(help="Data folder of the daemon.")] = Path("data"),
    port: PortOption = 8212,
    unit: Annotated[str, typer.Option(help="Its systemd unit.")] = "platform-daemon.service",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Check devices, disk, memory, clock, ports and service.  Exit code 1 if something must be corrected."""
    from platform_daemon.core.guard.preflight import run_preflight
    from platform_daemon.core.settings import load_platform

    from .device_tables import print_findings
    from .devices import read_back_by

    file = load_platform(platform, overrides or (), endpoints)
    must_not_exist(json_file, force, ".json")
    found = run_preflight(file, data, (port, port + 1), unit, read_back_by)
    write_json(json_file, found)
    print_findings(found)
    if found.fails:
        raise typer.Exit(1)

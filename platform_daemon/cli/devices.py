"""`platform-daemon devices | reset-amplifier`."""

from __future__ import annotations

import typer

from platform_daemon.reports import print_devices

from .interrupts import heed_one_interrupt
from .options import EndpointsOption, ForceOption, JsonOption, PlatformOption, SetOption
from .output import must_not_exist, write_json


def devices(
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """List what is there: identity, state and error of each device.  Exit code 1 if one is missing."""
    from drivers.inventory import find_devices
    from platform_daemon.settings import load_platform

    file = load_platform(platform, overrides or (), endpoints)
    must_not_exist(json_file, force)
    heed_one_interrupt()
    reports = [report.as_dict() for report in find_devices(file.section)]
    print_devices(reports)
    write_json(json_file, {"platform": file.section.name, "devices": reports})
    if any(report["error"] for report in reports):
        raise typer.Exit(1)


def reset_amplifier(
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Clear the amplifier's latched fault after a trip; no power goes out.  Find the cause first.

    While the daemon runs, ask it: POST /devices/power_amplifier/reset.
    """
    from platform_daemon.app import start_engine
    from platform_daemon.settings import load_platform

    heed_one_interrupt()
    engine = start_engine(load_platform(platform, overrides or (), endpoints))
    try:
        found = engine.reset_fault()
    finally:
        engine.close()
    was = "no fault was latched" if found["fault"] is None else f"cleared: {found['fault']}"
    print(f"{was}; the amplifier is disabled and muted")

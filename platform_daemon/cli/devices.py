"""`platform-daemon devices | reset-amplifier | config check`."""

from __future__ import annotations

from pathlib import Path

import typer

from drivers.errors import ConfigError
from platform_daemon.reports import print_devices

from .interrupts import heed_one_interrupt
from .options import EndpointsOption, ForceOption, JsonOption, PlatformOption, SetOption
from .output import must_not_exist, write_json

config_app = typer.Typer(help="Configuration files.")


def devices(
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """List what is there: identity, state and error of each device.  Exit code 1 if one is missing."""
    from drivers.inventory import find_devices
    from platform_daemon.schemas import DeviceReport, DeviceSurvey
    from platform_daemon.settings import load_platform

    file = load_platform(platform, overrides or (), endpoints)
    must_not_exist(json_file, force, ".json")
    heed_one_interrupt()
    reports = tuple(DeviceReport.model_validate(report.as_dict()) for report in find_devices(file.section))
    print_devices(reports)
    write_json(json_file, DeviceSurvey(platform=file.section.name, devices=reports))
    if any(report.error for report in reports):
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
    was = "no fault was latched" if found.fault is None else f"cleared: {found.fault}"
    print(f"{was}; the amplifier is disabled and muted")


def _check(path: Path, endpoints: Path | None = None) -> str:
    """One sentence on a valid platform, resonator or sequence file.  Raises ConfigError, DeviceError."""
    from platform_daemon.app import start_engine
    from platform_daemon.settings import load_platform, load_sequence, load_specimen, read_toml

    tables, _ = read_toml(path)
    if "io_card" in tables or "limits" in tables:
        engine = start_engine(load_platform(path, endpoints=endpoints))
        engine.close()
        return f"{path}: platform {engine.platform.name!r} is valid"
    if "magnets" in tables or "variant" in tables:
        return f"{path}: resonator {load_specimen(path)[0].name!r} is valid"
    if "f_tx_hz" in tables or "rx_s" in tables:
        load_sequence(path)
        return f"{path}: sequence is valid"
    remedy = "a platform has [io_card], a resonator [magnets], a sequence f_tx_hz"
    raise ConfigError("is neither a platform, a resonator nor a sequence", where=str(path), remedy=remedy)


@config_app.command("check")
def config_check(file: Path, endpoints: EndpointsOption = None) -> None:
    """Check a platform, resonator or sequence file; a platform's devices are built, not energised."""
    print(_check(file, endpoints))

"""`platform-daemon devices | reset-amplifier | config check`."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from drivers.errors import ConfigError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import (
    CsvOption,
    EndpointsOption,
    ForceOption,
    JsonOption,
    PlatformOption,
    SetOption,
)
from platform_daemon.core.command_line.output import must_not_exist, write_json

from .owning_daemon import daemon_of

if TYPE_CHECKING:
    from drivers.registry import PlatformSection
    from platform_daemon.core.schemas.platform import DeviceReport

config_app = typer.Typer(help="Configuration files.")


def devices(
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """List the devices with identity, state and error.  Exit code 1 if one is missing.

    Where a daemon owns the devices, the command reports what the daemon has read back last.
    """
    from platform_daemon.core.schemas.platform import DeviceSurvey
    from platform_daemon.core.settings import load_platform

    from .device_tables import print_devices

    file = load_platform(platform, overrides or (), endpoints)
    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    heed_one_interrupt()
    running = daemon_of(file.section)
    reports = _found(file.section) if running is None else read_back_by(running)
    write_json(json_file, DeviceSurvey(platform=file.section.name, devices=reports))
    write_csv(csv_file, reports)
    if running is not None:
        print(f"the daemon on {running} owns the devices; as it read them back last:")
    print_devices(reports)
    if any(report.error for report in reports):
        raise typer.Exit(1)


def _found(section: PlatformSection) -> tuple[DeviceReport, ...]:
    """Each device, opened and read back; no other program can open them meanwhile."""
    from drivers.inventory import find_devices
    from drivers.registry import outputs_outlive_process
    from platform_daemon.core.guard.ownership import hold_devices
    from platform_daemon.core.schemas.platform import DeviceReport

    with hold_devices(section) if outputs_outlive_process(section) else nullcontext():
        return tuple(DeviceReport.model_validate(report.as_dict()) for report in find_devices(section))


def read_back_by(daemon: Path) -> tuple[DeviceReport, ...]:
    """Each device as the daemon with this data folder read it back last."""
    from platform_daemon.core.schemas.platform import DeviceReport
    from platform_daemon.core.service.proxy import connect

    rows = connect(daemon).devices().items
    return tuple(
        DeviceReport(device=row.device, identity=row.identity, state=row.state, error=row.error) for row in rows
    )


def reset_amplifier(
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Clear the amplifier's latched fault after a trip; no power goes out.  Find the cause first.

    While the daemon runs, ask it: POST /devices/power_amplifier/reset.
    """
    from platform_daemon.core.settings import load_platform
    from platform_daemon.processes.assembly import start_engine

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
    from platform_daemon.core.schemas.requests import SequencePatch
    from platform_daemon.core.settings import load_platform, load_specimen, read_toml
    from platform_daemon.processes.assembly import start_engine

    tables, _ = read_toml(path)
    if "io_card" in tables or "limits" in tables:
        engine = start_engine(load_platform(path, endpoints=endpoints))
        engine.close()
        return f"{path}: platform {engine.platform.name!r} is valid"
    if "magnets" in tables or "variant" in tables:
        return f"{path}: resonator {load_specimen(path)[0].name!r} is valid"
    if set(tables) & set(SequencePatch.model_fields):
        return _check_sequence(path, tables)
    remedy = "a platform has [io_card], a resonator [magnets], a sequence keys such as f_tx_hz or field_t"
    raise ConfigError("is neither a platform, a resonator nor a sequence", where=str(path), remedy=remedy)


def _check_sequence(path: Path, tables: dict[str, Any]) -> str:
    """One sentence on a sequence, whole or with the keys that differ from a preset, as `measure --sequence` takes it.

    Raises ConfigError.
    """
    from drivers.validation import validated
    from platform_daemon.core.schemas.requests import SequencePatch
    from sequences.request import SequenceRequest

    needed = {name for name, field in SequenceRequest.model_fields.items() if field.is_required()}
    if needed <= set(tables):
        validated(SequenceRequest, tables, str(path))
        return f"{path}: sequence is valid"
    changes = {key: value for key, value in tables.items() if key not in ("repetitions", "blank_shots")}
    validated(SequencePatch, changes, str(path))
    return f"{path}: keys of a sequence are valid; the preset of the resonator has the others"


@config_app.command("check")
def config_check(file: Path, endpoints: EndpointsOption = None) -> None:
    """Check a platform, resonator or sequence file; a platform's devices are built, not energised."""
    print(_check(file, endpoints))

"""`platform-daemon calibrate receive | transmit`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.core.command_line.auditing import audit_in
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import PlatformOptions, ResultOptions, engine_of
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups

calibrate_app = typer.Typer(help="Calibrate the platform; every run writes a new version of its file.")

FolderOption = Annotated[Path, typer.Option("--out", help="Folder of the calibration files.")]
_CHANGES = {"frequencies_hz": {"flag": "--frequency-hz", "help": "May be repeated; default: 100 Hz to 8 kHz."}}
RECEIVE = offers(
    "CalibrationRequest", "name", "frequencies_hz", "repetitions", "listen_s", "temperature_span_c", changes=_CHANGES
)
TRANSMIT = offers(
    "CalibrationRequest", "name", "frequencies_hz", "repetitions", "amplifier_v", "temperature_span_c", changes=_CHANGES
)


@calibrate_app.command()
@option_groups
def receive(
    *,
    request: Annotated[Keys, RECEIVE],
    out: FolderOption = Path("data/calibrations"),
    where: PlatformOptions,
    result: ResultOptions,
) -> None:
    """Measure P, complex, per channel and frequency, with a reference dipole along x, y and z."""
    _calibrate({"kind": "receive", **request}, where, result, out)


@calibrate_app.command()
@option_groups
def transmit(
    *,
    request: Annotated[Keys, TRANSMIT],
    out: FolderOption = Path("data/calibrations"),
    where: PlatformOptions,
    result: ResultOptions,
) -> None:
    """Measure the field per volt of every coil with a field probe at the resonator's place."""
    _calibrate({"kind": "transmit", **request}, where, result, out)


def _calibrate(request: Keys, where: PlatformOptions, result: ResultOptions, out: Path) -> None:
    """Run a calibration to its end and show it.  Raises the job's error."""
    from drivers.validation import validated
    from platform_daemon.core.command_line.jobs import run_job
    from platform_daemon.core.schemas.calibrations import CalibrationReport
    from platform_daemon.core.schemas.requests import CalibrationRequest

    from .report import print_calibration
    from .work import plan_calibration

    checked = validated(CalibrationRequest, request, "calibrate")
    result.check()
    heed_one_interrupt()
    with engine_of(where) as engine:
        job = run_job(engine, plan_calibration(engine, checked, out))
    assert isinstance(job.result, CalibrationReport)
    report = job.result.root
    audit_in(out, "start_calibration", f"{report.kind}: {report.file}")
    write_json(result.json_file, report.model_copy(update={"warnings": tuple(job.warnings)}))
    for warning in job.warnings:
        typer.echo(f"warning: {warning}", err=True)
    print_calibration(report)
    low, high = report.valid_hz
    celsius = report.temperature_c
    at = "" if celsius is None or math.isnan(celsius) else f", made at {celsius:.2f} °C"
    table = "calibration" if report.kind == "receive" else "transmit_calibration"
    print(f'holds from {low:g} to {high:g} Hz{at}; to use it: [{table}] file = "{out / report.file}"')

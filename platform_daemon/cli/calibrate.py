"""`platform-daemon calibrate receive | transmit`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from drivers.validation import validated
from platform_daemon.reports import print_calibration

from .auditing import audit_in
from .interrupts import heed_one_interrupt
from .options import EndpointsOption, ForceOption, JsonOption, PlatformOption, SetOption
from .output import must_not_exist, write_json
from .progress import progress

calibrate_app = typer.Typer(help="Calibrate the platform; every run writes a new version of its file.")

FolderOption = Annotated[Path, typer.Option("--out", help="Folder of the calibration files.")]
NameOption = Annotated[str | None, typer.Option(help="Name of the file, without version and date; default: the kind.")]
FrequencyOption = Annotated[
    list[float] | None, typer.Option("--frequency-hz", help="May be repeated; default: 100 Hz to 8 kHz.")
]
RepetitionsOption = Annotated[int, typer.Option(min=1, help="Shots per direction and frequency.")]
SpanOption = Annotated[float, typer.Option(help="Holds so many deg C around the temperature it was made at.")]


@calibrate_app.command()
def receive(
    out: FolderOption = Path("data/calibrations"),
    name: NameOption = None,
    frequency_hz: FrequencyOption = None,
    repetitions: RepetitionsOption = 2,
    listen_s: Annotated[float, typer.Option(help="Length of a shot, s.")] = 0.4,
    temperature_span_c: SpanOption = 5.0,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Measure P, complex, per channel and frequency, with a reference dipole along x, y and z."""
    asked = {"kind": "receive", "name": name, "repetitions": repetitions, "temperature_span_c": temperature_span_c}
    asked |= {"listen_s": listen_s}
    _calibrate(asked, frequency_hz, out, (platform, overrides, endpoints), json_file, force)


@calibrate_app.command()
def transmit(
    out: FolderOption = Path("data/calibrations"),
    name: NameOption = None,
    frequency_hz: FrequencyOption = None,
    repetitions: RepetitionsOption = 2,
    amplifier_v: Annotated[float, typer.Option(help="Amplitude on each coil, V.")] = 1.0,
    temperature_span_c: SpanOption = 5.0,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Measure the field per volt of every coil with a field probe at the resonator's place."""
    asked = {"kind": "transmit", "name": name, "repetitions": repetitions, "temperature_span_c": temperature_span_c}
    asked |= {"amplifier_v": amplifier_v}
    _calibrate(asked, frequency_hz, out, (platform, overrides, endpoints), json_file, force)


def _calibrate(
    asked: dict[str, Any],
    frequency_hz: list[float] | None,
    out: Path,
    where: tuple[str, list[str] | None, Path | None],
    json_file: Path | None,
    force: bool,
) -> None:
    """Run a calibration to its end and show it.  Raises the job's error."""
    from platform_daemon.app import start_engine
    from platform_daemon.schemas import CalibrationReport, CalibrationRequest
    from platform_daemon.settings import load_platform

    if frequency_hz:
        asked["frequencies_hz"] = tuple(frequency_hz)
    request = validated(CalibrationRequest, asked, "calibrate")
    must_not_exist(json_file, force, ".json")
    heed_one_interrupt()
    engine = start_engine(load_platform(where[0], where[1] or (), where[2]))
    try:
        job = engine.calibrate(request, out)
        with progress() as display:
            display.watch(job)
    finally:
        engine.close()
    if job.error is not None:
        raise job.error
    for warning in job.warnings:
        typer.echo(f"warning: {warning}", err=True)
    assert isinstance(job.result, CalibrationReport)
    report = job.result.root
    audit_in(out, "start_calibration", f"{report.kind}: {report.file}")
    write_json(json_file, report.model_copy(update={"warnings": tuple(job.warnings)}))
    print_calibration(report)
    low, high = report.valid_hz
    celsius = report.temperature_c
    at = "" if celsius is None or math.isnan(celsius) else f", made at {celsius:.2f} °C"
    table = "calibration" if report.kind == "receive" else "transmit_calibration"
    print(f'holds from {low:g} to {high:g} Hz{at}; to use it: [{table}] file = "{out / report.file}"')

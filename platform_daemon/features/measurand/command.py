"""`platform-daemon measurand read | list`; the feature `sensor_calibration` adds `calibrate`, and has the command."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption
from platform_daemon.core.command_line.output import must_not_exist, write_json

measurand_app = typer.Typer(
    help="Use a resonator as a sensor: calibrate against a reference, read with uncertainty, list.",
    no_args_is_help=True,
)
FolderOption = Annotated[
    Path,
    typer.Option(
        "--measurands", help="Folder of the calibrations; `serve --data FOLDER` keeps them in FOLDER/measurands."
    ),
]
DEFAULT_FOLDER = Path("data", "measurands")


@measurand_app.command("read")
def read(
    file: Annotated[Path, typer.Argument(help="Recording.")],
    *,
    calibration: Annotated[
        str | None, typer.Option(help="KEY or KEY@VERSION; default: the newest of the specimen.")
    ] = None,
    coverage: Annotated[float, typer.Option(help="Probability of the interval value ± U.")] = 0.95,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Read outside of the range of the calibration, too.")
    ] = False,
    measurands: FolderOption = DEFAULT_FOLDER,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """Read a recording as a sensor: value and U of every shot and of their mean."""
    from platform_daemon.uncertainty.budget import checked_coverage

    from .report import readings_text
    from .stored import stored_readings

    checked_coverage(coverage)
    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    report = stored_readings(file, measurands, calibration, coverage, extrapolate)
    write_json(json_file, report)
    write_csv(csv_file, report.shots)
    if not report.shots:
        why = report.refused[0].reason if report.refused else "the recording has no shots"  # with the remedy
        raise InputError("none of its shots can be read", where=str(file), why=why)
    print(readings_text(report))


@measurand_app.command("list")
def list_calibrations(*, measurands: FolderOption = DEFAULT_FOLDER) -> None:
    """List all versions of all calibrations."""
    import sys

    from .library import Measurands

    found, broken = Measurands(measurands).all()
    for each in broken:
        print(f"warning: {each.error}", file=sys.stderr)
    lines = [f"{m.label}  {m.name} / {m.unit}, {m.valid_from:g} to {m.valid_to:g}, {m.ended[:10]}" for m in found]
    print("\n".join(lines) or "no resonator is calibrated as a sensor yet")

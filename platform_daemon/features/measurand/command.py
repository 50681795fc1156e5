"""`platform-daemon measurand`: a resonator as a sensor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json

measurand_app = typer.Typer(
    help="Use a resonator as a sensor: calibrate against a reference, read with uncertainty, list.",
    no_args_is_help=True,
)
FolderOption = Annotated[
    Path, typer.Option("--measurands", help="Folder of the calibrations; default: where `serve` keeps them.")
]
DEFAULT_FOLDER = Path("data", "measurands")


@measurand_app.command("calibrate")
def calibrate(
    specimen: Annotated[str, typer.Argument(help="Resonator, by name or file, with [measurand].")],
    files: Annotated[list[Path], typer.Argument(help="Recordings made while the reference was read.")],
    *,
    reference: Annotated[Path, typer.Option(help="CSV: time,NAME [UNIT],u [UNIT]; times with their zone.")],
    measurands: FolderOption = DEFAULT_FOLDER,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Calibrate a resonator against a reference: pairs matched in time, errors in both, checked, kept as a version."""
    from platform_daemon.core.command_line.progress import compile_fit
    from platform_daemon.core.settings import load_specimen
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.measurement import open_shots_for_fit

    from .library import Measurands
    from .reference_file import read_reference
    from .report import calibration_text
    from .shots import joined, shots_of
    from .work import calibrated, declared_measurand

    must_not_exist(json_file, force, ".json")
    found, _ = load_specimen(specimen)
    measurand = declared_measurand(found, specimen)
    readings = read_reference(reference, measurand)
    parts = []
    compile_fit()
    for file in files:
        measurement, ask = open_shots_for_fit(file, FitSettings(None, "d30"))
        say_note(measurement.path, measurement.other_layout)
        parts.append(shots_of(measurement, ask))
    shots = joined(parts)
    used = (reference, *files)
    made = calibrated(found.name, measurand, shots, readings, 0, used)
    kept = Measurands(measurands).add(made)
    write_json(json_file, kept)
    print(calibration_text(kept))


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

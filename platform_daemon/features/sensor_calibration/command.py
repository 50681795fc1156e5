"""`platform-daemon measurand calibrate`, beside `read` and `list` of the feature `measurand`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.options import ForceOption, JsonOption
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json
from platform_daemon.features.measurand.command import DEFAULT_FOLDER, measurand_app

if TYPE_CHECKING:
    from .series import Series

__all__ = ["measurand_app"]


@measurand_app.command()
def calibrate(
    specimen: Annotated[
        str, typer.Argument(help="Resonator with [measurand], by name (of --data, or shipped) or file.")
    ],
    files: Annotated[
        list[Path] | None, typer.Argument(help="Recordings made while the reference was read; or --schedule.")
    ] = None,
    *,
    schedule: Annotated[
        str | None, typer.Option(help="In place of files: name or id of a schedule, all its recordings of it.")
    ] = None,
    since: Annotated[str | None, typer.Option(help="Of the schedule what was started from then on, ISO 8601.")] = None,
    until: Annotated[
        str | None, typer.Option(help="Of the schedule what was started until then; a date: until its end.")
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option(
            help="CSV: time,NAME [UNIT],u [UNIT]; times with their zone. Left out, for `temperature` in degC: the "
            "platform's thermometer."
        ),
    ] = None,
    data: Annotated[
        Path, typer.Option("--data", help="Data folder of the daemon: added resonators, and the schedule.")
    ] = Path("data"),
    measurands: Annotated[
        Path | None, typer.Option("--measurands", help="Folder of the calibrations; default: that of --data.")
    ] = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Calibrate a resonator against a reference: pairs matched in time, errors in both, checked, kept as a version."""
    from drivers.specimen import Specimen
    from platform_daemon.core.command_line.progress import compile_fit
    from platform_daemon.core.hardware.catalogue import Shelf
    from platform_daemon.core.recordings.data_folder import data_paths
    from platform_daemon.core.recordings.evidence import file_digests
    from platform_daemon.features.measurand.library import Measurands
    from platform_daemon.features.measurand.reference_file import read_reference
    from platform_daemon.features.measurand.report import calibration_text
    from platform_daemon.features.measurand.work import declared_measurand

    from .stored import calibration_by

    must_not_exist(json_file, force, ".json")
    folders = data_paths(data)
    found, _ = Shelf("resonators", Specimen, added=folders.resonators).load(specimen)
    measurand = declared_measurand(found, specimen)
    readings = None
    if reference is not None:
        readings = read_reference(reference, measurand), file_digests((reference,))[0]
    given = _given(files, schedule, since, until, data)
    compile_fit()
    folder = measurands or folders.measurands
    made = calibration_by(found, given, readings, say_note, Measurands(folder).newest_of(found.name))
    kept = Measurands(folder).add(made)
    write_json(json_file, kept)
    print(calibration_text(kept))
    elsewhere = "" if folder == DEFAULT_FOLDER else f"; `measurand read` finds it with --measurands {folder}"
    print(f"kept: {folder / kept.label}.json{elsewhere}")


def _given(
    files: list[Path] | None, schedule: str | None, since: str | None, until: str | None, data: Path
) -> list[Path] | Series:
    """Raises InputError."""
    from platform_daemon.features.schedules.command import schedules_of

    from .series import series_of

    if bool(files) == (schedule is not None):
        remedy = "name recordings, or --schedule NAME"
        raise InputError("the calibration is by recordings or by a schedule", where="FILES, --schedule", remedy=remedy)
    if schedule is not None:
        return series_of(schedules_of(data), schedule, data / "recordings", since, until)
    if since is not None or until is not None:
        remedy = "give --schedule NAME, or leave them out"
        raise InputError("they choose recordings of a schedule", where="--since, --until", remedy=remedy)
    assert files
    return files

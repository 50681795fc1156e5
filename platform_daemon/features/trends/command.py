"""`platform-daemon trend | index rebuild`: what a specimen does over months."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption, StepOption
from platform_daemon.core.command_line.output import must_not_exist, write_json

index_app = typer.Typer(help="The index of recordings, from which trends are computed; it can be rebuilt.")
FolderOption = Annotated[Path, typer.Option("--recordings", help="Folder of the recordings.")]
FOLDER = Path("data/recordings")
FALSE_ALARM = 20_000.0


def trend(
    specimen: Annotated[str, typer.Argument(help="Name of the sample, or of the resonator if none was given.")],
    recordings: FolderOption = FOLDER,
    since: Annotated[
        str | None, typer.Option(help="Begin there, ISO 8601; the control charts restart there, too.")
    ] = None,
    until: Annotated[str | None, typer.Option(help="End there, ISO 8601.")] = None,
    step: StepOption = None,
    points_to_false_alarm: Annotated[
        float, typer.Option(help="Points to a false alarm, on average over all charts.")
    ] = FALSE_ALARM,
    uncertainty: Annotated[
        bool, typer.Option("--uncertainty", help="U of every value, by a budget for each calibration.")
    ] = False,
    measurands: Annotated[
        Path | None, typer.Option(help="Folder of the calibrations as a sensor; default: beside the recordings.")
    ] = None,
    accept: Annotated[
        str | None,
        typer.Option(
            help="Accept it as it is, from --since or its next recording on, and why: the control charts restart."
        ),
    ] = None,
    by: Annotated[str, typer.Option(help="Who accepts it.")] = "",
    png: Annotated[Path | None, typer.Option(help="Picture of the trend to write.")] = None,
    csv: Annotated[Path | None, typer.Option(help="Write the points as a table.")] = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Show how a specimen changes over months: values at one temperature, control charts, named changes."""
    from platform_daemon.core.state.durable import write_file

    from .indexed import indexed_trend
    from .readings import with_measurand
    from .report import trend_csv, trend_text

    for path, ending in ((png, ".png"), (csv, ".csv"), (json_file, ".json")):
        must_not_exist(path, force, ending)
    _check_accepted(accept, by)
    updated(recordings, rebuild=False)
    if accept is not None:
        indexed_trend(recordings, specimen)  # raises for a specimen that has no recordings
        _accept(recordings, specimen, {"reason": accept, "by": by, **({} if since is None else {"since": since})})
        since = None
    if uncertainty:
        from platform_daemon.core.command_line.progress import compile_fit

        compile_fit()
    report = indexed_trend(recordings, specimen, since, until, points_to_false_alarm, step, uncertainty=uncertainty)
    report = with_measurand(report, recordings, measurands or recordings.parent / "measurands")
    write_json(json_file, report)
    if csv is not None:
        write_file(csv, trend_csv(report).encode())
    if png is not None:
        from .figure import save_trend_png  # here, because matplotlib needs a folder that it may write

        save_trend_png(report, png)
    print(trend_text(report))


def _check_accepted(why: str | None, by: str) -> None:
    """Raises InputError that names the option."""
    if why is not None and not why.strip():
        raise InputError("says no reason", where="--accept", remedy="say why it is accepted: --accept 'new jewel'")
    if why is not None and not by.strip():
        raise InputError("no person is named", where="--by", remedy="say who accepts it: --by NAME")


def _accept(folder: Path, specimen: str, keys: dict[str, str]) -> None:
    """Raises InputError, StorageError."""
    from drivers.validation import validated

    from .baseline import accept
    from .schema import BaselineRequest

    made = accept(folder, specimen, validated(BaselineRequest, keys, "trend --accept"))
    print(f"accepted as it is since {made.since}")


@index_app.command()
def rebuild(recordings: FolderOption = FOLDER) -> None:
    """Rebuild the index from all files."""
    print(f"{updated(recordings, rebuild=True)} files looked at")


@index_app.command()
def find(
    recordings: FolderOption = FOLDER,
    specimen: Annotated[str | None, typer.Option(help="Name of the sample, or of the resonator.")] = None,
    resonator: Annotated[str | None, typer.Option(help="Name of the resonator, as its file says.")] = None,
    operator: Annotated[str | None, typer.Option(help="Part of the operator's name.")] = None,
    since: Annotated[str | None, typer.Option(help="Begun from then on, ISO 8601.")] = None,
    until: Annotated[str | None, typer.Option(help="Begun until then, ISO 8601; a date: until its end.")] = None,
    refused: Annotated[
        bool | None, typer.Option("--refused/--not-refused", help="With a refused shot, or without.")
    ] = None,
    tag: Annotated[str | None, typer.Option(help="A word of the comment after #.")] = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """List the files of the recordings that meet all conditions, one a line."""
    from platform_daemon.core.recordings.indexed import Wanted

    from .indexed import find_recordings, summaries_of

    must_not_exist(csv_file, force, ".csv")
    updated(recordings, rebuild=False)
    wanted = Wanted(specimen, operator, since, until, refused, tag, resonator)
    found = {Path(name).stem: recordings / name for name in find_recordings(recordings, wanted)}
    if csv_file is not None:
        known = summaries_of(recordings, tuple(found))
        write_csv(csv_file, ({"id": name, "path": path.name, **asdict(known[name])} for name, path in found.items()))
    for path in found.values():
        print(path)


@index_app.command()
def export(
    specimen: Annotated[str, typer.Argument(help="Name of the sample, or of the resonator if none was given.")],
    csv: Annotated[Path | None, typer.Option(help="Table to write, a row per shot and window.")] = None,
    parquet: Annotated[Path | None, typer.Option(help="The same as Parquet; needs pyarrow.")] = None,
    recordings: FolderOption = FOLDER,
    force: ForceOption = False,
) -> None:
    """Write the on-line fits of all shots of a specimen as one table."""
    from platform_daemon.core.state.durable import write_file

    from .exported import exported_fits
    from .fit_exports import fits_csv, fits_parquet

    if csv is None and parquet is None:
        raise InputError("no file is named", where="--csv", remedy="name one with --csv or --parquet")
    must_not_exist(csv, force, ".csv")
    must_not_exist(parquet, force, ".parquet")
    updated(recordings, rebuild=False)
    rows = exported_fits(recordings, specimen)
    for path, table in ((csv, fits_csv), (parquet, fits_parquet)):
        if path is not None:
            write_file(path, table(rows))
    for path in filter(None, (csv, parquet)):
        print(f"{len(rows)} fits in {path}")


def updated(folder: Path, *, rebuild: bool) -> int:
    """Raises InputError if there is no such folder; files that cannot be read are named on stderr."""
    from rich.console import Console

    from .indexed import update_index

    if not folder.is_dir():
        raise InputError("is no folder", where=str(folder), remedy="name the folder of the recordings, --recordings")
    shown = sys.stderr.isatty()

    terminal = Console(stderr=True, highlight=False)

    def show(n: int, of: int) -> None:
        if shown and of:
            terminal.print(f"{n} of {of} recordings looked at", end="\n" if n == of else "\r")

    found, broken = update_index(folder, show, rebuild=rebuild)
    for why in broken.values():
        print(f"left out: {why}", file=sys.stderr)
    return found.looked

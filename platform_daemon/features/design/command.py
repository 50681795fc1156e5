"""`platform-daemon design | defects`: what a design says, and what manufacturing defects do to it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption
from platform_daemon.core.command_line.output import must_not_exist, write_json

if TYPE_CHECKING:
    from .schema import DefectsRequest

ResonatorOption = Annotated[
    str | None, typer.Option(help="thread, jewel, or a resonator file; default: the paper's design point.")
]
_MOST_NUMBERS = 100_000


def design(
    resonator: ResonatorOption = None,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """Print what magnets and bearing alone say: moment, frequency, forces, friction, and the paper's six steps."""
    from platform_daemon.core.settings import load_specimen

    from .numbers import design_report
    from .report import design_text, step_rows

    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    report = design_report(None if resonator is None else load_specimen(resonator)[0])
    write_json(json_file, report)
    write_csv(csv_file, step_rows(report))
    print(design_text(report))


def defects(
    defect: Annotated[str, typer.Option(help="stator_tilt, lateral; rotor_tilt (thread), jewel_tilt (jewel).")],
    bearing: Annotated[str, typer.Option(help="thread or jewel.")],
    eps_deg: Annotated[str | None, typer.Option(help="Tilts, as 0.5,2 or FROM:TO:COUNT, degrees.")] = None,
    dy_mm: Annotated[str | None, typer.Option(help="Displacements, as 0.1,0.2 or FROM:TO:COUNT, mm.")] = None,
    phi_deg: Annotated[str, typer.Option(help="Deflections, as 10,30 or FROM:TO:COUNT, degrees.")] = "30",
    cup_radius_over_r: Annotated[str | None, typer.Option(help="R/r of a jewel, or inf; default: 5/3.")] = None,
    thread_length_over_r: Annotated[str | None, typer.Option(help="l/r of a thread, or inf; default: 8.")] = None,
    pivot: Annotated[
        str | None, typer.Option(help="Of a jewel_tilt: contact (default), rotor_centre or stator_centre.")
    ] = None,
    direction: Annotated[
        str | None,
        typer.Option(help="Of a displacement, against the magnetisation: along (default) or across."),
    ] = None,
    resonator: ResonatorOption = None,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    png: Annotated[Path | None, typer.Option(help="Write pictures like the paper's figures.")] = None,
    force: ForceOption = False,
) -> None:
    """Equivalent perpendicular force of a manufacturing defect: what pushes the rotor into side modes."""
    from platform_daemon.core.settings import load_specimen

    from .checked_defect import checked_defect
    from .defects import defects_report
    from .report import defects_text

    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    must_not_exist(png, force, ".png")
    keys: dict[str, object] = {
        "defect": defect,
        "bearing": bearing,
        "eps_deg": _numbers(eps_deg, "--eps-deg"),
        "dy_mm": _numbers(dy_mm, "--dy-mm"),
        "phi_deg": _numbers(phi_deg, "--phi-deg"),
        "cup_radius_over_r": _ratio(cup_radius_over_r, "--cup-radius-over-r"),
        "thread_length_over_r": _ratio(thread_length_over_r, "--thread-length-over-r"),
        "pivot": pivot,
        "direction": direction,
    }
    specimen = None if resonator is None else load_specimen(resonator)[0]
    checked = checked_defect(_request(keys), specimen, by_option=True)
    report = defects_report(checked)
    write_json(json_file, report)
    write_csv(csv_file, report.cases)
    if png is not None:
        from .curves import force_curves
        from .figure import save_defects_png  # here, because matplotlib is loaded with it

        save_defects_png(force_curves(checked, specimen), png)
    print(defects_text(report))
    if png is not None:
        print(png)


def _request(keys: dict[str, object]) -> DefectsRequest:
    """Raises InputError that names the option."""
    from pydantic import ValidationError

    from drivers.validation import complaints

    from .schema import DefectsRequest

    try:
        return DefectsRequest.model_validate(keys)
    except ValidationError as error:
        first, *_ = complaints(error.errors(), DefectsRequest)
    key = first.where.partition(".")[0].replace("_", "-")
    what, where = first.what.removeprefix("is wrong: "), f"--{key}" if key else "sizes and --phi-deg"
    raise InputError(what, where=where, remedy="see platform-daemon defects --help")


def _numbers(text: str | None, option: str) -> list[float] | None:
    """ "0.5,2", "0:10:100" (from, to, count) or several of them.  Raises InputError."""
    if text is None:
        return None
    found: list[float] = []
    try:
        for part in text.split(","):
            found += _range(part) if ":" in part else [float(part)]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        remedy = "write finite numbers with commas, as in 0.5,2, or FROM:TO:COUNT, as in 0:10:101"
        raise InputError(f"{text!r} is no list of numbers", where=option, remedy=remedy)
    return found


def _range(text: str) -> list[float]:
    """From, to and count, both ends in.  Raises ValueError."""
    start, stop, count = text.split(":")
    low, high, n = float(start), float(stop), int(count)
    if not 2 <= n <= _MOST_NUMBERS:
        raise ValueError(text)
    return [low + (high - low) * k / (n - 1) for k in range(n)]


def _ratio(text: str | None, option: str) -> float | str | None:
    """Raises InputError."""
    if text is None or text in ("inf", "+inf"):
        return None if text is None else "inf"
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{text!r} is no ratio of lengths", where=option, remedy="give a number, or inf")
    return value

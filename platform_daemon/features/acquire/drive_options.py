"""What the command line says of a drive: keys of a sequence, values of its model, changes from shot to shot."""

from __future__ import annotations

import json
import statistics
from pathlib import Path
from typing import Annotated, Any

import typer

from drivers.errors import InputError
from drivers.text_files import read_text_file
from platform_daemon.core.command_line.parsing import parse_points

DriveOption = Annotated[
    list[str] | None,
    typer.Option(
        "--drive", help="KEY=VALUE of the sequence, as waveform=rectangle or phase_plan=model; may be repeated."
    ),
]
_OF_ONE_SHOT = ("phi_max_rad", "psi_start_rad", "rodrigues_x", "rodrigues_y", "rodrigues_z")
_IN_UNITS = {"field_ut": ("field_t", 1e-6), "field_mt": ("field_t", 1e-3)}


def shot_changes(texts: list[str]) -> list[dict[str, Any]]:
    """The changes of every shot: several keys go in lockstep.  Raises InputError."""
    from drivers.validation import validated
    from platform_daemon.core.schemas.sweep_axis import SweepAxis

    axes = [validated(SweepAxis, parse_points(text, "--per-shot"), "--per-shot") for text in texts]
    if len({len(axis.points) for axis in axes}) > 1:
        counts = ", ".join(f"{axis.key} {len(axis.points)}" for axis in axes)
        raise InputError(
            f"the lists are not equally long: {counts}", where="--per-shot", remedy="give as many values of each key"
        )
    rows = zip(*(axis.points for axis in axes), strict=True)
    return [dict(_in_si(axis.key, value) for axis, value in zip(axes, row, strict=True)) for row in rows]


def _in_si(key: str, value: Any) -> tuple[str, Any]:
    name, factor = _IN_UNITS.get(key, (key, None))
    return name, value * factor if factor is not None and isinstance(value, int | float) else value


def planned_from(file: Path, keys: dict[str, Any]) -> dict[str, Any]:
    """The keys with a drive planned by the medians of the good fits in a JSON file.

    Raises InputError: no such file, no good fit in it.  What `keys` says itself goes before.
    """
    from platform_daemon.core.schemas.acquisitions import SeriesReport
    from platform_daemon.core.schemas.fits import FitReport

    try:
        content = json.loads(read_text_file(file))
        report = SeriesReport.model_validate(content).fit if "shots" in content else FitReport.model_validate(content)
    except (OSError, ValueError, TypeError, RecursionError) as error:
        remedy = "give what `platform-daemon fit FILE --json` or `measure --json` has written for one recording"
        why = str(error).splitlines()[0]
        raise InputError(f"{file} holds no fits", where="--plan-from", why=why, remedy=remedy) from None
    good = [frame.parameters for frame in report.frames if frame.good] if report is not None else []
    if not good:
        raise InputError(f"{file} holds no good fit", where="--plan-from", remedy="give fits that are good")
    names = [n for n in good[0] if n not in _OF_ONE_SHOT and all(n in p for p in good)]
    values = {n: statistics.median(p[n].value for p in good) for n in names}
    return {"phase_plan": "model", **keys, "plan_parameters": values | keys.get("plan_parameters", {})}

"""`platform-daemon predict`: what a planned measurement can tell."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from drivers.errors import InputError
from platform_daemon.reports import COLUMNS

from .options import TermOption
from .output import must_not_exist, write_json


def predict(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    variant: Annotated[str | None, typer.Option(help="The model to be fitted; default: the resonator's.")] = None,
    term: TermOption = None,
    expect: Annotated[list[str] | None, typer.Option("--expect", help="NAME=VALUE expected of the model.")] = None,
    window: Annotated[list[str] | None, typer.Option(help="n50, d30 or seconds; may be repeated.")] = None,
    deflection_deg: Annotated[float | None, typer.Option(help="phi_max; default: the paper's.")] = None,
    noise: Annotated[str, typer.Option(help="Noise of x,y,z per sample, A m^2/s.")] = "0.014,0.021,0.055",
    rate_hz: Annotated[float, typer.Option(help="Sampling rate, Hz.")] = 125e6 / 2048,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the result as JSON.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")] = False,
) -> None:
    """Predict the smallest standard deviations a measurement can reach (Cramer-Rao bound, white noise)."""
    from platform_daemon.analysis import PAPER_DEFLECTION_DEG, checked_variant
    from platform_daemon.analysis import planned_precision as bound
    from platform_daemon.settings import load_specimen

    from .parsing import parse_values, parse_window

    specimen = load_specimen(resonator)[0]
    degrees = PAPER_DEFLECTION_DEG[specimen.variant] if deflection_deg is None else deflection_deg
    if not 0 < degrees < 90:
        raise InputError(f"{degrees} deg is no deflection", where="--deflection-deg", remedy="give 0 to 90 deg")
    must_not_exist(json_file, force)
    found = bound(
        specimen,
        [parse_window(w) for w in window or ("n50", "d30")],
        phi_max_rad=math.radians(degrees),
        noise_am2_per_s=_levels(noise),
        sampling_rate_hz=rate_hz,
        variant=checked_variant(variant or specimen.variant, term or ()),
        expected=parse_values(expect or [], "--expect"),
    )
    Console(width=150).print(_table(found))
    write_json(json_file, found)


def _levels(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        remedy = "write three numbers with commas, as in 0.014,0.021,0.055"
        raise InputError(f"{text!r} are no noise levels", where="--noise", remedy=remedy) from None


def _table(found: dict[str, Any]) -> Table:
    table = Table(title=f"{found['variant']}: smallest standard deviations", title_justify="left")
    for heading in ("window / s", *(c[1] for c in COLUMNS), "orientation / °"):
        table.add_column(heading, justify="right")
    for row in found["windows"]:
        cells = [f"{row['std'][n] * factor:.2g}" if n in row["std"] else "-" for n, _, factor in COLUMNS]
        table.add_row(f"{row['window_s']:.3f}", *cells, f"{math.degrees(row['orientation_rad']):.2g}")
    return table

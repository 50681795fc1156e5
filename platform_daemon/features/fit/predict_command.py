"""`platform-daemon predict`: how precise a planned measurement can be."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption, TermOption
from platform_daemon.core.command_line.output import must_not_exist, write_json
from platform_daemon.core.command_line.request_fields import REQUEST_FIELDS

_FIELDS = REQUEST_FIELDS["PredictionRequest"]
_PAPER_NOISE = ",".join(map(str, _FIELDS["noise_am2_per_s"].default))


def predict(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    variant: Annotated[str | None, typer.Option(help="The model to be fitted; default: the resonator's.")] = None,
    term: TermOption = None,
    expect: Annotated[list[str] | None, typer.Option("--expect", help="NAME=VALUE expected of the model.")] = None,
    window: Annotated[list[str] | None, typer.Option(help="n50, d30 or seconds; may be repeated.")] = None,
    deflection_deg: Annotated[float | None, typer.Option(help="phi_max; default: the paper's.")] = None,
    noise: Annotated[str, typer.Option(help="Noise of x,y,z per sample, A m^2/s.")] = _PAPER_NOISE,
    rate_hz: Annotated[float, typer.Option(help="Sampling rate, Hz.")] = _FIELDS["sampling_rate_hz"].default,
    fix: Annotated[list[str] | None, typer.Option("--fix", help="Hold NAME or NAME=VALUE fixed.")] = None,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """Predict the smallest standard deviations a measurement can reach (Cramer-Rao bound, white noise)."""
    from platform_daemon.core.command_line.parsing import check_parameter, parse_values, parse_window
    from platform_daemon.core.schemas.parameters import PAPER_DEFLECTION_DEG
    from platform_daemon.core.settings import load_specimen
    from platform_daemon.features.models.resolve import checked_variant

    from .precision import planned_precision
    from .report import prediction_table_text

    specimen = load_specimen(resonator)[0]
    degrees = PAPER_DEFLECTION_DEG[specimen.variant] if deflection_deg is None else deflection_deg
    if not 0 < degrees < 90:
        raise InputError(f"{degrees} deg is no deflection", where="--deflection-deg", remedy="give 0 to 90 deg")
    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    fixed = [text.partition("=")[0] for text in fix or ()]
    for name in fixed:
        check_parameter(name, "--fix")
    held = parse_values([text for text in fix or () if "=" in text], "--fix") or {}
    found = planned_precision(
        specimen,
        [parse_window(w) for w in window or ("n50", "d30")],
        phi_max_rad=math.radians(degrees),
        noise_am2_per_s=_levels(noise),
        sampling_rate_hz=rate_hz,
        fixed=tuple(fixed),
        variant=checked_variant(variant or specimen.variant, term or ()),
        expected=(parse_values(expect or [], "--expect") or {}) | held,
    )
    write_json(json_file, found)
    write_csv(csv_file, found.windows)
    print(prediction_table_text(found))


def _levels(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        remedy = "write three numbers with commas, as in 0.014,0.021,0.055"
        raise InputError(f"{text!r} are no noise levels", where="--noise", remedy=remedy) from None

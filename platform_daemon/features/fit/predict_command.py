"""`platform-daemon predict`: how precise a planned measurement can be."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import ModelsOption, TableOptions, TermOption
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.command_line.request_fields import REQUEST_FIELDS
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups
from platform_daemon.features.models.options import library

_FIELDS = REQUEST_FIELDS["PredictionRequest"]
_PAPER_NOISE = ",".join(map(str, _FIELDS["noise_am2_per_s"].default))

_DRIVE = offers(
    "PredictionRequest",
    *(f"sequence.{key}" for key in ("f_tx_hz", "tx_periods", "field_ut", "axis", "rx_s")),
)


@option_groups
def predict(
    *,
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    variant: Annotated[str | None, typer.Option(help=_FIELDS["variant"].help)] = None,
    term: TermOption = None,
    estimate_adopted: Annotated[
        bool, typer.Option("--estimate-adopted", help=_FIELDS["estimate_adopted"].help)
    ] = False,
    expect: Annotated[list[str] | None, typer.Option("--expect", help="NAME=VALUE expected of the model.")] = None,
    window: Annotated[list[str] | None, typer.Option(help="n50, d30 or seconds; may be repeated.")] = None,
    deflection_deg: Annotated[float | None, typer.Option(help="phi_max; default: the paper's.")] = None,
    drive: Annotated[Keys, _DRIVE],
    noise: Annotated[str, typer.Option(help="Noise of x,y,z per sample, A m^2/s.")] = _PAPER_NOISE,
    rate_hz: Annotated[float, typer.Option(help="Sampling rate, Hz.")] = _FIELDS["sampling_rate_hz"].default,
    fix: Annotated[list[str] | None, typer.Option("--fix", help="Hold NAME or NAME=VALUE fixed.")] = None,
    models: ModelsOption = None,
    result: TableOptions,
) -> None:
    """Predict the smallest standard deviations a measurement can reach (Cramer-Rao bound, white noise).

    The drive is that of an adopted model with a manufacturing error; other motions begin with their deflection.
    """
    from drivers.validation import validated
    from platform_daemon.core.command_line.parsing import check_parameter, parse_values, parse_window
    from platform_daemon.core.schemas.requests import SequencePatch
    from platform_daemon.core.settings import load_specimen

    from .precision import planned_model, planned_precision
    from .report import prediction_table_text

    specimen = load_specimen(resonator)[0]
    if deflection_deg is not None and not 0 < deflection_deg < 90:
        what, remedy = f"{deflection_deg} deg is no deflection", "give 0 to 90 deg"
        raise InputError(what, where="--deflection-deg", remedy=remedy)
    result.check()
    fixed = [text.partition("=")[0] for text in fix or ()]
    for name in fixed:
        check_parameter(name, "--fix")
    held = parse_values([text for text in fix or () if "=" in text], "--fix") or {}
    found = planned_precision(
        specimen,
        [parse_window(w) for w in window or ("n50", "d30")],
        phi_max_rad=None if deflection_deg is None else math.radians(deflection_deg),
        noise_am2_per_s=_levels(noise),
        sampling_rate_hz=rate_hz,
        fixed=tuple(fixed),
        model=planned_model(variant, term or (), library(models), specimen),
        estimate_adopted=estimate_adopted,
        expected=(parse_values(expect or [], "--expect") or {}) | held,
        sequence=validated(SequencePatch, drive.get("sequence", {}), "sequence"),
    )
    write_json(result.json_file, found)
    write_csv(result.csv_file, found.windows)
    print(prediction_table_text(found))


def _levels(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        remedy = "write three numbers with commas, as in 0.014,0.021,0.055"
        raise InputError(f"{text!r} are no noise levels", where="--noise", remedy=remedy) from None

"""`platform-daemon slide`: fits along one ring-down, window by window."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, get_args

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import (
    CalibrationOption,
    CsvOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    TermOption,
    VariantOption,
    calibration_in,
)
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json
from platform_daemon.features.models.options import variant_named

if TYPE_CHECKING:
    from platform_daemon.estimation.sliding_window import LambdaMode


def slide(
    file: Path,
    frame: Annotated[int, typer.Option(min=0, help="Frame, from 0.")] = 0,
    window: Annotated[float | None, typer.Option(help="Length of a window, s; default: an eighth of D30.")] = None,
    step: Annotated[float | None, typer.Option(help="From window to window, s; default: no overlap.")] = None,
    damping: Annotated[str, typer.Option("--lambda", help="Jewel: auto, free or fixed (to the D30 value).")] = "auto",
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    calibration: CalibrationOption = None,
    out: Annotated[Path | None, typer.Option(help="PNG to write.")] = None,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """Fit window by window: with a complete model f_nat, m_r, lambda and T_f/I are flat lines."""
    from platform_daemon.core.command_line.progress import compile_fit

    from .fit_request import FitRefused
    from .measurement import open_measurement
    from .sliding import flatness_lines, slide_frame, sliding_report
    from .sliding_figure import save_sliding_png

    must_not_exist(out, force, ".png")
    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    mode, model = _mode(damping), variant_named(variant, models)
    measurement = open_measurement(file, calibration_in(calibration))
    say_note(measurement.path, measurement.other_layout)
    compile_fit()
    try:
        found = slide_frame(
            measurement, frame, model, window, step, mode, terms=term or (), options=("--window", "--step")
        )
    except FitRefused as refused:
        print(f"error: {refused}", file=sys.stderr)
        raise typer.Exit(3) from None
    report = sliding_report(found).model_copy(update={"file": str(file), "frame": frame})
    write_json(json_file, report)
    write_csv(csv_file, (each.model_dump(exclude={"covariance"}) for each in report.windows))
    if out is not None:
        save_sliding_png(found, f"{file.name}, frame {frame}, {variant or measurement.variant}", out)
    print("\n".join(flatness_lines(found)))
    if out is not None:
        print(out)
    if not report.good_windows:
        print("every window was refused", file=sys.stderr)
        raise typer.Exit(3)


def _mode(damping: str) -> LambdaMode:
    """Raises InputError."""
    from platform_daemon.estimation.sliding_window import LambdaMode

    for known in get_args(LambdaMode):
        if damping == known:
            return known
    raise InputError(f"no mode {damping!r}", where="--lambda", remedy="give auto, free or fixed")

"""`platform-daemon info | plot`: what a recording holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.reports import print_recording

from .options import (
    CalibrationOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    TermOption,
    VariantOption,
    WindowOption,
    calibration_in,
    variant_named,
)
from .output import must_not_exist, write_json
from .parsing import parse_window


def info(file: Path, json_file: JsonOption = None, force: ForceOption = False) -> None:
    """Say what a recording holds."""
    from platform_daemon.store import describe, open_recording

    facts = describe(open_recording(file))
    must_not_exist(json_file, force, ".json")
    print_recording(facts)
    write_json(json_file, facts)


def plot(
    file: Path,
    frame: Annotated[int, typer.Option(min=0, help="Frame, from 0.")] = 0,
    png: Annotated[Path | None, typer.Option(help="PNG to write; default: beside the recording.")] = None,
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    window: WindowOption = "d30",
    calibration: CalibrationOption = None,
    force: ForceOption = False,
) -> None:
    """Draw dm/dt with the fit over it, the residual and the spectrum."""
    from platform_daemon.analysis import open_voltages, ring_down_plot_data
    from platform_daemon.reports import save_png

    measurement = open_voltages(file, calibration_in(calibration))
    target = png or file.with_name(f"{file.name.removesuffix('.h5').removesuffix('.mmr')}-frame{frame}.png")
    must_not_exist(target, force, ".png")
    model = variant_named(variant, models)
    save_png(ring_down_plot_data(measurement, frame, model, parse_window(window), term or ()), target)
    print(target)

"""`platform-daemon info | plot`: what a recording holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.core.command_line.options import (
    CalibrationOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    TermOption,
    VariantOption,
    WindowOption,
    calibration_in,
)
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json
from platform_daemon.core.command_line.parsing import parse_window
from platform_daemon.features.models.options import variant_named


def info(file: Path, json_file: JsonOption = None, force: ForceOption = False) -> None:
    """Show what a recording, an angle series or a table contains.

    Of a table: its columns, what each is read as, and the lines that a TOML file next to it has to give, if they say
    too little.
    """
    from platform_daemon.core.recordings.angle_series import AngleSeries, is_time_series, read_angles
    from platform_daemon.core.recordings.column_file import columns_in, is_column_file, read_columns
    from platform_daemon.core.recordings.description import describe, describe_angle
    from platform_daemon.core.recordings.reader import open_recording

    from .report import print_angle, print_columns, print_next, print_recording

    must_not_exist(json_file, force, ".json")
    columns = columns_in(file) if is_column_file(file) else ()
    print_columns(file, columns)
    if columns:
        found = read_columns(file)
    else:
        found = read_angles(file) if is_time_series(file) else open_recording(file)
    if isinstance(found, AngleSeries):
        angle = describe_angle(found, file.stat().st_size, columns)
        write_json(json_file, angle)
        print_angle(angle)
    else:
        say_note(file, found.other_layout)
        facts = describe(found)
        write_json(json_file, facts)
        print_recording(facts)
    if columns or isinstance(found, AngleSeries):
        print_next(file, "" if isinstance(found, AngleSeries) else " --variant jewel")


def plot(
    file: Path,
    frame: Annotated[int, typer.Option(min=0, help="Frame, from 0.")] = 0,
    png: Annotated[Path | None, typer.Option(help="PNG to write; default: next to the recording.")] = None,
    interactive: Annotated[
        bool, typer.Option("--interactive", help="Write a page to zoom in next to the recording, and open it.")
    ] = False,
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    window: WindowOption = "d30",
    calibration: CalibrationOption = None,
    force: ForceOption = False,
) -> None:
    """Draw dm/dt, volts or an angle with the fit over it, the residual and the spectrum.

    --interactive: the signal and the residual on an HTML page instead (with --png, as well).
    """
    from platform_daemon.core.command_line.progress import compile_fit
    from platform_daemon.core.state.durable import write_file
    from platform_daemon.features.fit.measurement import open_measurement
    from platform_daemon.features.fit.plot_data import ring_down_plot_data
    from platform_daemon.features.fit.ring_down_figure import save_png
    from platform_daemon.features.fit.ring_down_page import open_in_browser, ring_down_html

    measurement = open_measurement(file, calibration_in(calibration))
    say_note(measurement.path, measurement.other_layout)
    stem = f"{file.name.removesuffix('.h5').removesuffix('.mmr')}-frame{frame}"
    html = file.with_name(f"{stem}.html") if interactive else None
    target = png or (None if interactive else file.with_name(f"{stem}.png"))
    must_not_exist(target, force, ".png")
    must_not_exist(html, force, ".html")
    model = variant_named(variant, models)
    compile_fit()
    picture = ring_down_plot_data(measurement, frame, model, parse_window(window), term or ())
    if target is not None:
        save_png(picture, target)
        print(target)
    if html is not None:
        write_file(html, ring_down_html(picture))
        print(html)
        open_in_browser(html)

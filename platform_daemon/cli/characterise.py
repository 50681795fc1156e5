"""`platform-daemon characterise`: the paper's tables and figures of one resonator, from many shots."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.schemas import SIGNIFICANCE

from .interrupts import end_at_once, heed_one_interrupt
from .options import (
    CalibrationOption,
    ForceOption,
    FramesOption,
    HtmlOption,
    JsonOption,
    ModelsOption,
    TermOption,
    VariantOption,
    calibration_in,
    variant_named,
)
from .output import keep_page, must_not_exist, write_json
from .progress import prepare_fit, progress

if TYPE_CHECKING:
    from platform_daemon.analysis import CharacterisationTask
    from platform_daemon.schemas import CharacterisationReport


def characterise(
    source: Annotated[Path | None, typer.Option("--from", help="Recording with the shots of one resonator.")] = None,
    frames: FramesOption = None,
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    calibration: CalibrationOption = None,
    hold: Annotated[
        list[str] | None, typer.Option("--hold", help="Hold the loss NAME=VALUE in N50; default: lambda, of D30.")
    ] = None,
    alpha: Annotated[float, typer.Option(min=1e-12, max=0.5, help="Level of significance.")] = SIGNIFICANCE,
    json_file: JsonOption = None,
    html: HtmlOption = None,
    force: ForceOption = False,
) -> None:
    """Fit many shots over N50 and D30: tables and figures of the paper, and whether the two windows agree."""
    from platform_daemon.analysis import FitSettings, characterisation_task

    from .parsing import parse_frames, parse_values

    if source is None:
        raise InputError("nothing to characterise", where="--from", remedy="name a recording")
    must_not_exist(json_file, force, ".json")
    must_not_exist(html, force, ".html", ".htm")
    settings = FitSettings(
        variant_named(variant, models),
        calibration=calibration_in(calibration),
        terms=tuple(term or ()),
        frames=None if frames is None else parse_frames(frames),
    )
    held = parse_values(hold, "--hold") if hold else None
    heed_one_interrupt()
    try:
        tell_characterisation(characterisation_task(source, settings, held, alpha), json_file, html)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()


def tell_characterisation(task: CharacterisationTask, json_file: Path | None, html: Path | None) -> None:
    """Fit with a bar, print the tables, write what was asked for.  Raises typer.Exit: 3 if no shot has a fit."""
    from platform_daemon.reports import characterisation_text

    report = _fitted(task)
    print(characterisation_text(report))
    write_json(json_file, report)
    if html is not None:
        from platform_daemon.analysis import shown_shot
        from platform_daemon.reports import characterisation_html

        keep_page(html, characterisation_html(report, shown_shot(task, report)))
    if not (report.n50.good or report.d30.good):
        print("every shot was refused in both windows", file=sys.stderr)
        raise typer.Exit(3)


def _fitted(task: CharacterisationTask) -> CharacterisationReport:
    from platform_daemon.analysis import characterise as fit_and_tell

    from .fit import workers_for

    prepare_fit()  # or the time of the first fit would be that of compiling
    with progress() as display, workers_for(task.frames) as workers:
        return fit_and_tell(task, workers, display.tell)

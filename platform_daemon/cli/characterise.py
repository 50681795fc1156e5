"""`platform-daemon characterise`: the paper's tables and figures of one resonator, from many shots."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
from drivers.validation import validated
from platform_daemon.schemas import SIGNIFICANCE

from .interrupts import end_at_once, heed_one_interrupt
from .options import (
    CalibrationOption,
    EndpointsOption,
    ForceOption,
    FramesOption,
    HtmlOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    SetOption,
    TermOption,
    VariantOption,
    calibration_in,
    library,
    variant_named,
)
from .output import keep_page, must_not_exist, write_json
from .procedure import conduct
from .progress import prepare_fit, progress

if TYPE_CHECKING:
    from platform_daemon.analysis import CharacterisationTask
    from platform_daemon.engine import Engine, Job
    from platform_daemon.schemas import CharacterisationReport


def characterise(
    resonator: Annotated[str | None, typer.Option(help="Measure this one: thread, jewel, or a resonator file.")] = None,
    source: Annotated[
        Path | None, typer.Option("--from", help="Or a recording with the shots of one resonator.")
    ] = None,
    shots: Annotated[int, typer.Option(min=1, help="Excited shots.")] = 100,
    blank_shots: Annotated[int, typer.Option(min=0, help="Shots without excitation before them.")] = 4,
    field_ut: Annotated[float | None, typer.Option(help="Excitation field, uT; default: the preset's.")] = None,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: the preset's.")] = None,
    pause_s: Annotated[float | None, typer.Option(help="Wait between shots, s; default: the preset's.")] = None,
    out: Annotated[
        Path | None, typer.Option("--output", "--out", help="Recording to write; default: characterise.h5.")
    ] = None,
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    comment: Annotated[str, typer.Option(help="Comment for the record.")] = "",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check the shots and show the plan; nothing moves.")
    ] = False,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
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
    """Fit many shots over N50 and D30: tables and figures of the paper, and whether the two windows agree.

    Either of shots that are made now (--resonator), or of a recording (--from).
    """
    from platform_daemon.app import start_engine
    from platform_daemon.settings import load_platform

    from .parsing import parse_frames, parse_values

    if (resonator is None) == (source is None):
        remedy = "name a resonator to measure, or a recording"
        raise InputError("give one of the two", where="--resonator, --from", remedy=remedy)
    must_not_exist(json_file, force, ".json")
    must_not_exist(html, force, ".html", ".htm")
    held = parse_values(hold, "--hold") if hold else None
    if source is not None:
        chosen = None if frames is None else parse_frames(frames)
        settings = (variant_named(variant, models), calibration_in(calibration), tuple(term or ()), chosen)
        _characterise_recording(source, settings, held, alpha, json_file, html)
        return
    for name, value in (("--frames", frames), ("--calibration", calibration), ("--with-term", term)):
        if value is not None:
            remedy = "measure first, then give it with --from"
            raise InputError("goes with a recording", where=name, remedy=remedy)
    sequence = {"field_t": None if field_ut is None else field_ut * 1e-6, "rx_s": rx_s, "pause_s": pause_s}
    known = {
        "resonator": resonator,
        "shots": shots,
        "blank_shots": blank_shots,
        "sequence": {name: value for name, value in sequence.items() if value is not None},
        "variant": variant,
    } | {"sample": sample, "operator": operator, "comment": comment}
    asked = {"kind": "characterise", "acquisition": known, "held_in_n50": held or {}, "alpha": alpha}
    target = out or Path("characterise.h5")
    must_not_exist(None if dry_run else target, force, ".h5", ".hdf5", ".mmr")
    heed_one_interrupt()
    engine = start_engine(load_platform(platform, overrides or (), endpoints), models=library(models))
    try:
        _measured(engine, asked, target, json_file, html, dry_run=dry_run, force=force)
    finally:
        engine.close()


def _measured(
    engine: Engine, asked: dict[str, Any], out: Path, json_file: Path | None, html: Path | None, *, dry_run: bool,
    force: bool,
) -> None:  # fmt: skip
    """Raises InputError, and what `conduct` raises."""
    from platform_daemon.engine import CharacterisationFiles
    from platform_daemon.reports import characterisation_html, characterisation_text
    from platform_daemon.schemas import CharacteriseOutcome, CharacteriseRequest

    def tell(job: Job) -> None:
        if isinstance(job.result.outcome, CharacteriseOutcome):
            print(characterisation_text(job.result.outcome.report))
            if html is not None:
                print(html)

    request = validated(CharacteriseRequest, asked, "characterise")
    tables = CharacterisationFiles(characterisation_html, report=json_file, html=html)
    conduct(engine, request, out, json_file, dry_run=dry_run, overwrite=force, tables=tables, tell=tell)


def _characterise_recording(
    source: Path, asked: tuple[Any, ...], held: dict[str, float] | None, alpha: float, json_file: Path | None,
    html: Path | None,
) -> None:  # fmt: skip
    """asked: model, calibration, further terms, frames."""
    from platform_daemon.analysis import FitSettings, characterisation_task

    model, calibration, terms, frames = asked
    settings = FitSettings(model, calibration=calibration, terms=terms, frames=frames)
    heed_one_interrupt()
    try:
        _tell(characterisation_task(source, settings, held, alpha), json_file, html)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()


def _tell(task: CharacterisationTask, json_file: Path | None, html: Path | None) -> None:
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

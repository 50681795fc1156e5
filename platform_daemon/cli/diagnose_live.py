"""`platform-daemon diagnose --live`: measure, diagnose, run the proposed next measurement, diagnose again."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.validation import validated

from .interrupts import heed_one_interrupt
from .options import (
    ForceOption,
    HtmlOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    SetOption,
    VariantOption,
    library,
    variant_named,
)
from .output import must_not_exist, write_json, write_page
from .progress import ProgressDisplay, progress

if TYPE_CHECKING:
    from platform_daemon.diagnosis import Measurement
    from platform_daemon.engine import Callbacks, LiveDiagnosis


def diagnose_live(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    out: Annotated[Path, typer.Option(help="Folder for the series of the loop and its log.")],
    shots: Annotated[int, typer.Option(min=1, help="Shots of the first series.")] = 6,
    budget_shots: Annotated[int, typer.Option(min=1, help="Shots in all.")] = 60,
    budget_s: Annotated[float, typer.Option(min=0.0, help="Seconds after which no further series begins.")] = 3600.0,
    manual: Annotated[
        bool, typer.Option("--manual", help="Ask for manual steps and wait; else they are listed.")
    ] = False,
    field_ut: Annotated[float | None, typer.Option(help="Excitation field, uT; default: the preset's.")] = None,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: the preset's.")] = None,
    variant: VariantOption = None,
    models: ModelsOption = None,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    json_file: JsonOption = None,
    html: HtmlOption = None,
    force: ForceOption = False,
) -> None:
    """Diagnose on the platform: measure, diagnose, run the next measurement, until explained or out of budget."""
    from platform_daemon.analysis import NothingToDiagnoseError
    from platform_daemon.app import start_engine
    from platform_daemon.engine import Budget, LiveDiagnosis
    from platform_daemon.schemas import AcquisitionRequest
    from platform_daemon.settings import load_platform

    changed = {"field_t": None if field_ut is None else field_ut * 1e-6, "rx_s": rx_s}
    sequence = {k: v for k, v in changed.items() if v is not None}
    asked = {"resonator": resonator, "shots": shots, "sequence": sequence, "window": None}
    request = validated(AcquisitionRequest, asked, "diagnose")
    model = variant_named(variant, models)
    out.mkdir(parents=True, exist_ok=True)
    must_not_exist(json_file, force, ".json")
    must_not_exist(html, force, ".html", ".htm")
    heed_one_interrupt()
    engine = start_engine(load_platform(platform, overrides or ()), models=library(models))
    loop = LiveDiagnosis(engine, request, out, Budget(budget_shots, budget_s), model=model)
    try:
        with progress() as display:
            loop.callbacks = _callbacks(display, manual)
            loop.run()
    except NothingToDiagnoseError as error:
        print(f"error: {error}", file=sys.stderr)
        raise typer.Exit(3) from None
    finally:
        engine.close()
        if loop.rounds:
            _report(loop, out, json_file, html)


def _callbacks(display: ProgressDisplay, manual: bool) -> Callbacks:
    """How the loop talks; manual: the operator is asked for steps that need a hand."""
    from platform_daemon.engine import Callbacks

    def ask(step: Measurement) -> bool:
        answer = display.ask(f"{step.what}. Enter: it is done; s: leave it out")
        return not answer.strip().lower().startswith("s")

    return Callbacks(display.watch, display.tell, display.say, ask if manual else lambda step: False)


def _report(loop: LiveDiagnosis, out: Path, json_file: Path | None, html: Path | None) -> None:
    """The log in the folder, the last diagnosis where --json and --html say, and what is left to do by hand."""
    log = loop.log()
    number = 1
    while (path := out / f"live-{number:02d}.json").exists():
        number += 1
    write_json(path, log)
    if loop.found is not None and log.diagnosis is not None:
        report = log.diagnosis.model_copy(update={"files": log.files, "recordings": log.recordings})
        write_json(json_file, report)
        write_page(html, loop.found, report)
    print(f"{log.stopped}; {log.shots} shots in {len(log.rounds)} series; log in {path}")
    for step in log.manual_steps_left:
        print(f"left to do by hand: {step.what}")


class FilesOrLive(typer.core.TyperCommand):
    """`diagnose`, whose --live takes other options: those of `diagnose_live`."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        """The context of the command that is meant."""
        if "--live" not in args:
            return super().make_context(info_name, args, *more, **extra)
        rest = [a for a in args if a != "--live"]
        return _live_command().make_context(f"{info_name} --live", rest, *more, **extra)


def _live_command() -> Any:
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(diagnose_live)
    return typer.main.get_command(app)

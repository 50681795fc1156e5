"""`platform-daemon diagnose --live`: measure, diagnose, run the proposed next measurement, diagnose again."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import (
    HtmlOption,
    KeptOptions,
    PlatformOptions,
    ResultOptions,
    VariantOption,
    measuring_engine,
)
from platform_daemon.core.command_line.output import must_not_exist, write_json, write_page
from platform_daemon.core.command_line.request_fields import Limits
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups
from platform_daemon.features.models.options import variant_named

from .command import residual_page

if TYPE_CHECKING:
    from platform_daemon.core.command_line.progress import ProgressDisplay
    from platform_daemon.diagnosis.findings.next_measurements import Measurement

    from .live import Callbacks, LiveDiagnosis


SERIES = offers(
    "AcquisitionRequest",
    "resonator",
    "preset",
    "shots",
    "sequence.field_ut",
    "sequence.rx_s",
    changes={"shots": {"help": "Shots of the first series.", "default": 6, "limits": Limits(low=1)}},
)


@dataclass(frozen=True, kw_only=True)
class BudgetOptions:
    """What the loop may use."""

    budget_shots: Annotated[int, typer.Option(min=1, help="Shots in all.")] = 60
    budget_s: Annotated[float, typer.Option(min=0.0, help="Seconds after which no further series begins.")] = 3600.0


@option_groups
def diagnose_live(
    *,
    series: Annotated[Keys, SERIES],
    out: Annotated[Path, typer.Option(help="Folder for the series of the loop and its log.")],
    budget: BudgetOptions,
    manual: Annotated[
        bool, typer.Option("--manual", help="Ask for manual steps and wait; else they are listed.")
    ] = False,
    variant: VariantOption = None,
    kept: KeptOptions,
    platform: PlatformOptions,
    html: HtmlOption = None,
    result: ResultOptions,
) -> None:
    """Diagnose on the platform: measure, diagnose, run the next measurement, until explained or out of budget."""
    from drivers.validation import validated
    from platform_daemon.core.command_line.progress import progress
    from platform_daemon.core.schemas.requests import AcquisitionRequest

    from .live import Budget, LiveDiagnosis
    from .load_shots import NothingToDiagnoseError

    request = validated(AcquisitionRequest, {**series, "window": None}, "diagnose")
    model = variant_named(variant, kept.models)
    out.mkdir(parents=True, exist_ok=True)
    result.check()
    must_not_exist(html, result.force, ".html", ".htm")
    heed_one_interrupt()
    limits = Budget(budget.budget_shots, budget.budget_s)
    with ExitStack() as at_end:
        engine = at_end.enter_context(measuring_engine(platform, kept))
        loop = LiveDiagnosis(engine, request, out, limits, model=model)
        at_end.callback(_report_rounds, loop, out, result.json_file, html)
        at_end.callback(engine.close)  # outputs are off before anything is written
        with progress() as display:
            loop.callbacks = _callbacks(display, manual)
            try:
                loop.run()
            except NothingToDiagnoseError as error:
                print(f"error: {error}", file=sys.stderr)
                raise typer.Exit(3) from None


def _report_rounds(loop: LiveDiagnosis, out: Path, json_file: Path | None, html: Path | None) -> None:
    if loop.rounds:
        _report(loop, out, json_file, html)


def _callbacks(display: ProgressDisplay, manual: bool) -> Callbacks:
    """How the loop reports; manual: it asks the operator for steps by hand, else it lists them."""
    from .live import Callbacks

    def ask(step: Measurement) -> bool:
        answer = display.ask(f"{step.what}. Enter: it is done; s: leave it out")
        return not answer.strip().lower().startswith("s")

    return Callbacks(display.watch, display.tell, display.say, ask if manual else lambda step: False)


def _report(loop: LiveDiagnosis, out: Path, json_file: Path | None, html: Path | None) -> None:
    """The log in the folder, the last diagnosis where --json and --html say, and what is left to do by hand."""
    from platform_daemon.core.schemas.text import counted

    log = loop.log()
    number = 1
    while (path := out / f"live-{number:02d}.json").exists():
        number += 1
    write_json(path, log)
    if loop.found is not None and log.diagnosis is not None:
        report = log.diagnosis.model_copy(update={"files": log.files, "recordings": log.recordings})
        write_json(json_file, report)
        if html is not None:
            write_page(html, residual_page(loop.found, report))
            print(html)
    print(f"{log.stopped}; {counted(log.shots, 'shot')} in {len(log.rounds)} series; log in {path}")
    for step in log.manual_steps_left:
        print(f"left to do by hand: {step.what}")

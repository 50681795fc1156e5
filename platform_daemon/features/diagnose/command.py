"""`platform-daemon diagnose`: what the declared model lacks, with proof by data that were not used."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import end_at_once, heed_one_interrupt
from platform_daemon.core.command_line.options import (
    CalibrationOption,
    ForceOption,
    HtmlOption,
    JsonOption,
    ModelsOption,
    StepOrAllOption,
    VariantOption,
)
from platform_daemon.core.command_line.output import must_not_exist, write_json, write_page
from platform_daemon.features.models.options import variant_named

if TYPE_CHECKING:
    from platform_daemon.diagnosis.diagnose import Diagnosis
    from platform_daemon.diagnosis.report_schema import DiagnosisReport

    from .load_shots import Observable


def diagnose(
    files: Annotated[list[Path], typer.Argument(help="Recordings or angle series of one specimen.")],
    variant: VariantOption = None,
    observable: Annotated[
        str | None, typer.Option(help="dmdt, or angle for files with /time and /signal; default: what the files hold.")
    ] = None,
    base: Annotated[str | None, typer.Option("--base", help="Start from this declared or adopted model.")] = None,
    models: ModelsOption = None,
    calibration: CalibrationOption = None,
    step: StepOrAllOption = None,
    json_file: JsonOption = None,
    html: HtmlOption = None,
    force: ForceOption = False,
) -> None:
    """Find effects that the declared model lacks: strength, significance, and better prediction.

    With --live on a platform, instead of files: measure, diagnose, measure what is proposed (diagnose --live --help).
    """
    from platform_daemon.core.command_line.progress import compile_fit, progress
    from platform_daemon.core.recordings.evidence import file_digests
    from platform_daemon.core.recordings.reader import read_calibration
    from platform_daemon.diagnosis.report import diagnosis_report

    from .load_shots import NothingToDiagnoseError, diagnose_input, load_diagnosis_input
    from .report import summary_text

    began = time.perf_counter()
    other = None if calibration is None else (read_calibration(calibration), str(calibration))
    must_not_exist(json_file, force, ".json")
    must_not_exist(html, force, ".html", ".htm")
    heed_one_interrupt()
    try:
        specimen = load_diagnosis_input(
            files, variant_named(variant, models), _observable(observable), variant_named(base, models), other,
            steps=dict.fromkeys(files, step),
        )  # fmt: skip
        compile_fit()
        with progress() as display:
            found = diagnose_input(specimen, display.tell)
        report = diagnosis_report(
            found,
            files=list(map(str, specimen.files)),
            recordings=file_digests(specimen.files),
            value_sources=specimen.recorded_sources(str),
            seconds=time.perf_counter() - began,  # what the user waited, reading of the files included
        )
        write_json(json_file, report)
        if html is not None:
            write_page(html, residual_page(found, report))
        print(summary_text(report))
        if html is not None:
            print(html)
    except NothingToDiagnoseError as error:
        print(f"error: {error}", file=sys.stderr)
        raise typer.Exit(3) from None
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()


def residual_page(found: Diagnosis, report: DiagnosisReport) -> bytes:
    """The report with pictures of what the fits leave over before and after the diagnosis, which are computed here."""
    from platform_daemon.diagnosis.residual_comparison import compare_residuals

    from .page import diagnosis_html

    return diagnosis_html(report, compare_residuals(found))


def _observable(name: str | None) -> Observable | None:
    """Raises InputError."""
    from .load_shots import OBSERVABLES

    if name is None:
        return None
    for known in OBSERVABLES:
        if name == known:
            return known
    raise InputError(f"no observable {name!r}", where="--observable", remedy=f"one of: {', '.join(OBSERVABLES)}")

"""`platform-daemon diagnose`: what the declared model lacks, with proof by data that were not used."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError

from .interrupts import end_at_once, heed_one_interrupt
from .options import (
    CalibrationOption,
    ForceOption,
    HtmlOption,
    JsonOption,
    ModelsOption,
    VariantOption,
    variant_named,
)
from .output import must_not_exist, write_json, write_page
from .progress import progress

if TYPE_CHECKING:
    from platform_daemon.analysis import Observable


def diagnose(
    files: Annotated[list[Path], typer.Argument(help="Recordings or angle series of one specimen.")],
    variant: VariantOption = None,
    observable: Annotated[
        str | None, typer.Option(help="dmdt, or angle for files with /time and /signal; default: what the files hold.")
    ] = None,
    base: Annotated[str | None, typer.Option("--base", help="Start from this declared or adopted model.")] = None,
    models: ModelsOption = None,
    calibration: CalibrationOption = None,
    json_file: JsonOption = None,
    html: HtmlOption = None,
    force: ForceOption = False,
) -> None:
    """Say what the declared model lacks: which effect, how strong, how sure, and how much better it predicts.

    With --live on a platform, instead of files: measure, diagnose, measure what is proposed (diagnose --live --help).
    """
    from platform_daemon.analysis import NothingToDiagnoseError, diagnose_input, file_digests, load_diagnosis_input
    from platform_daemon.diagnosis import diagnosis_report
    from platform_daemon.reports import summary_text
    from platform_daemon.store import read_calibration

    began = time.perf_counter()
    other = None if calibration is None else (read_calibration(calibration), str(calibration))
    must_not_exist(json_file, force, ".json")
    must_not_exist(html, force, ".html", ".htm")
    heed_one_interrupt()
    try:
        specimen = load_diagnosis_input(
            files, variant_named(variant, models), _observable(observable), variant_named(base, models), other
        )
        with progress() as display:
            found = diagnose_input(specimen, display.tell)
        report = diagnosis_report(found).model_copy(
            update={
                "files": tuple(map(str, specimen.files)),
                "recordings": file_digests(specimen.files),
                "seconds": time.perf_counter() - began,  # what the user waited, reading of the files included
            }
        )
        print(summary_text(report))
        write_json(json_file, report)
        write_page(html, found, report)
    except NothingToDiagnoseError as error:
        print(f"error: {error}", file=sys.stderr)
        raise typer.Exit(3) from None
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()


def _observable(name: str | None) -> Observable | None:
    """Raises InputError."""
    from platform_daemon.analysis import OBSERVABLES

    if name is None:
        return None
    for known in OBSERVABLES:
        if name == known:
            return known
    raise InputError(f"no observable {name!r}", where="--observable", remedy=f"one of: {', '.join(OBSERVABLES)}")

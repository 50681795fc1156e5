"""`platform-daemon tune`: find a resonator's frequency, and the sequence that it is measured best with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import (
    KeptOptions,
    PlatformOptions,
    TableOptions,
    measuring_engine,
)
from platform_daemon.core.command_line.recording_target import prepare_target
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups

TUNE = offers(
    "TuneRequest",
    "acquisition.resonator",
    "acquisition.sequence.f_tx_hz",
    "weak_field_ut",
    "max_field_ut",
    "acquisition.sequence.field_ut",
    "acquisition.sequence.axis",
    "keep",
    "acquisition.window",
    "acquisition.variant",
    "acquisition.sample",
    "acquisition.operator",
    "acquisition.comment",
    changes={
        "acquisition.sequence.f_tx_hz": {
            "help": "Where the search begins, Hz; default: the design's natural frequency."
        },
        "acquisition.sequence.field_ut": {"help": "Field of the sequence that is found, uT; default: the preset's."},
    },
)


@option_groups
def tune(
    *,
    request: Annotated[Keys, TUNE],
    out: Annotated[Path, typer.Option("--output", "--out", help="Recording to write.")] = Path("tune.h5"),
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check the shots and show the plan; nothing moves.")
    ] = False,
    kept: KeptOptions,
    where: PlatformOptions,
    result: TableOptions,
) -> None:
    """Find f_nat in at most five weak shots, and from it f_TX, t_TX, t_RX and the pause; kept as the preset."""
    from drivers.validation import validated
    from platform_daemon.features.procedures.command import conduct

    from .report import outcome_text
    from .schema import TuneOutcome, TuneRequest
    from .work import NotTuned

    checked = validated(TuneRequest, {"kind": "tune", **request}, "tune")
    result.check()
    prepare_target(out, force=result.force, dry_run=dry_run)
    heed_one_interrupt()
    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        conduct(
            engine,
            checked,
            out,
            result.json_file,
            dry_run=dry_run,
            overwrite=result.force,
            csv_file=result.csv_file,
            found=lambda made: print(outcome_text(made.outcome)) if isinstance(made.outcome, TuneOutcome) else None,
            unusable=NotTuned,
        )

"""`platform-daemon ramp`: the field at which side modes show, found without going far beyond it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import KeptOptions, PlatformOptions, TableOptions, measuring_engine
from platform_daemon.core.command_line.output import must_not_exist, write_json
from platform_daemon.core.command_line.recording_target import prepare_target
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups

if TYPE_CHECKING:
    from platform_daemon.features.procedures.schema import ProcedureResult

    from .schema import RampOutcome

RAMP = offers(
    "RampRequest",
    "acquisition.resonator",
    "acquisition.preset",
    "acquisition.sequence.axis",
    "start_ut",
    "step_ut",
    "max_ut",
    "overdose_rate",
    "most_shots",
    "acquisition.sequence.rx_s",
    "acquisition.sequence.pause_s",
    "acquisition.beyond_side_modes",
    "predicted_by",
    "acquisition.sample",
    "acquisition.operator",
    changes={
        "acquisition.sequence.rx_s": {"help": "RX window, s; default: 2 s, or the preset's."},
        "acquisition.sequence.pause_s": {"help": "Wait between shots, s; default: until it rests."},
    },
)


@option_groups
def ramp(
    *,
    request: Annotated[Keys, RAMP],
    out: Annotated[Path, typer.Option("--output", "--out", help="Recording to write.")] = Path("ramp.h5"),
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check every step and show the plan; nothing moves.")
    ] = False,
    png: Annotated[Path | None, typer.Option(help="Picture of the ramp to write.")] = None,
    kept: KeptOptions,
    where: PlatformOptions,
    result: TableOptions,
) -> None:
    """Raise the field until side modes show; find their threshold and the field to work at."""
    from drivers.validation import validated
    from platform_daemon.features.procedures.command import conduct

    from .schema import RampOutcome, RampRequest

    checked = validated(RampRequest, {"kind": "ramp", **request}, "ramp")
    result.check()
    must_not_exist(png, result.force, ".png")
    prepare_target(out, force=result.force, dry_run=dry_run)
    heed_one_interrupt()

    def write(found: ProcedureResult) -> None:
        if isinstance(found.outcome, RampOutcome):
            _write(found.outcome, result, png)

    def report(found: ProcedureResult) -> None:
        if isinstance(found.outcome, RampOutcome):
            _print(found.outcome, png)

    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        conduct(
            engine,
            checked,
            out,
            None,
            dry_run=dry_run,
            overwrite=result.force,
            csv_file=result.csv_file if dry_run else None,  # else the table is that of its fields
            write=write,
            report=report,
        )


def _write(found: RampOutcome, where: TableOptions, png: Path | None) -> None:
    write_json(where.json_file, found)
    write_csv(where.csv_file, found.steps)
    if png is not None:
        from .report import save_ramp_png

        save_ramp_png(found, png)


def _print(found: RampOutcome, png: Path | None) -> None:
    from .report import ramp_text

    print(ramp_text(found))
    if png is not None:
        print(png)

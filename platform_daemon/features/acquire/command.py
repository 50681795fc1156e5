"""`platform-daemon measure`: a series of shots without a server."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.interrupts import INTERRUPTED, heed_one_interrupt
from platform_daemon.core.command_line.options import (
    DryRunOption,
    KeptOptions,
    PlatformOptions,
    TableOptions,
    measuring_engine,
)
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.command_line.parsing import parse_keys
from platform_daemon.core.command_line.recording_target import prepare_target
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups

from .drive_options import DriveOption, planned_from, shot_changes

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.core.schemas.acquisitions import AcquisitionResult, AcquisitionSummary

    from .planning import AcquisitionPlan
    from .work import AcquisitionJob

SERIES = offers(
    "AcquisitionRequest",
    "resonator",
    "preset",
    "shots",
    "blank_shots",
    "sequence.f_tx_hz",
    "sequence.tx_periods",
    "sequence.field_ut",
    "sequence.axis",
    "sequence.rx_s",
    "sequence.pause_s",
    "window",
    "variant",
    "beyond_side_modes",
    "sample",
    "operator",
    "comment",
)


@dataclass(frozen=True, kw_only=True)
class DriveOptions:
    """How the drive differs from the resonator's preset, beyond what single options say."""

    sequence: Annotated[
        str | None, typer.Option(help="Sequence file with the keys that differ from the resonator's preset.")
    ] = None
    drive: DriveOption = None
    plan_from: Annotated[
        Path | None, typer.Option(help="Plan the drive with the fits in this JSON file, as --json writes them.")
    ] = None
    per_shot: Annotated[
        list[str] | None,
        typer.Option(help="KEY=FROM:TO:STEP or KEY=A,B,C, shot by shot; several: in lockstep."),
    ] = None

    def apply(self, request: Keys, *, force: bool) -> None:
        """Add what they say to the keys of a request; single options come before the file.  Raises InputError."""
        keys = _sequence_file(self.sequence, request["resonator"], force) if self.sequence else {}
        keys |= request.get("sequence", {}) | parse_keys(self.drive or [], "--drive")
        request["sequence"] = keys if self.plan_from is None else planned_from(self.plan_from, keys)
        if self.per_shot:
            request["shot_changes"] = shot_changes(self.per_shot)


@option_groups
def measure(
    *,
    series: Annotated[Keys, SERIES],
    drive_options: DriveOptions,
    out: Annotated[
        Path | None, typer.Option("--output", "--out", help="Recording to write; needed unless it is a dry run.")
    ] = None,
    dry_run: DryRunOption = False,
    kept: KeptOptions,
    where: PlatformOptions,
    result: TableOptions,
) -> None:
    """Measure a series of shots and fit each; every shot is on disk before it counts."""
    from drivers.validation import validated
    from platform_daemon.core.schemas.requests import AcquisitionRequest
    from platform_daemon.core.state.disk_space import check_room

    from .series_plan import plan_series

    drive_options.apply(series, force=result.force)
    request = validated(AcquisitionRequest, series, "measure")
    if out is None and not dry_run:
        raise InputError("there is no name for the recording", where="--out", remedy="give --out, or --dry-run")
    result.check()
    if dry_run and result.csv_file is not None:
        raise InputError("a dry run has no fits to write", where="--csv", remedy="leave one of the two out")
    if out is not None:
        prepare_target(out, force=result.force, dry_run=dry_run)
    heed_one_interrupt()
    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        plan = plan_series(engine, request)
        if dry_run or out is None:
            summary = plan.summary()
            _show_plan(summary, result.json_file)
            check_room(out.parent if out is not None else Path(), summary.disk_bytes, summary.shots)
            return
        job, interrupted = _run(engine, plan, out, overwrite=result.force)
    _conclude(job, out, result, interrupted)


def _show_plan(summary: AcquisitionSummary, json_file: Path | None) -> None:
    from .report import dry_run_text

    write_json(json_file, summary)
    print(dry_run_text(summary))


def _run(engine: Engine, plan: AcquisitionPlan, out: Path, *, overwrite: bool) -> tuple[AcquisitionJob, bool]:
    """The series at its end, and whether it was interrupted."""
    from platform_daemon.core.command_line.progress import interrupted_while, prepare_fit

    from .destination import OwnFile
    from .series_plan import series_work

    prepare_fit()
    job = engine.submit(series_work(engine, plan, OwnFile(out, out.parent, overwrite=overwrite)))
    return job, interrupted_while(engine, job)


def _sequence_file(name: str, resonator: str, force: bool) -> dict[str, Any]:
    """The keys of a sequence file; the numbers of shots are options.  Raises InputError.

    `force` allows the preset of the other bearing.
    """
    from drivers.validation import validated
    from platform_daemon.core.schemas.requests import SequencePatch
    from platform_daemon.core.settings import load_specimen, locate, read_toml, refuse_foreign_preset

    path = locate("sequences", name)
    specimen, _ = load_specimen(resonator)
    if not force:
        remedy = f"leave --sequence out for the preset of the {specimen.variant} bearing, or insist with --force"
        refuse_foreign_preset(path, specimen, f"--sequence {name}", remedy)
    keys = {key: value for key, value in read_toml(path)[0].items() if key not in ("repetitions", "blank_shots")}
    return validated(SequencePatch, keys, str(path)).changes()


def _conclude(job: AcquisitionJob, out: Path, where: TableOptions, interrupted: bool) -> None:
    """What came out.  Raises what ended it; typer.Exit: 130 interrupted, 3 if no shot can be used."""
    _report_series(job, out, where)
    if interrupted:
        raise typer.Exit(INTERRUPTED)
    if job.error is not None:
        raise job.error
    _refuse_unusable(job.result)


def _refuse_unusable(result: AcquisitionResult) -> None:
    """Exit code 3 if shots were fitted and not one gave a result."""
    excited = [] if result.fit is None else [f for f in result.fit.frames if not f.blank]
    if excited and not any(f.good for f in excited):
        print(f"no shot can be used: {excited[0].reason}", file=sys.stderr)
        raise typer.Exit(3)


def _report_series(job: AcquisitionJob, out: Path, where: TableOptions) -> None:
    """What came out of a series, also of one that was cut short."""
    from platform_daemon.core.schemas.acquisitions import SeriesReport
    from platform_daemon.core.schemas.value_sources import value_sources_text
    from platform_daemon.features.fit.report import fit_rows, fit_table_text

    result = job.result
    if result.file is not None:
        report = SeriesReport(
            file=str(out),
            recording=result.recording,
            shots=result.shots,
            fit=result.fit,
            value_sources=result.value_sources,
        )
        write_json(where.json_file, report)
        write_csv(where.csv_file, () if result.fit is None else fit_rows(result.fit))
    for warning in job.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if result.fit is not None:
        print(fit_table_text(result.fit))
    if result.value_sources:
        print(value_sources_text(result.value_sources))
    print(f"{result.shots or 0} of {int(job.total)} shots" + ("" if result.file is None else f" in {out}"))

"""`platform-daemon measure`: a series of shots without a server."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
from drivers.validation import validated
from platform_daemon.reports import dry_run_text, fit_table_text

from .drive import DriveOption, planned_from, shot_changes
from .interrupts import INTERRUPTED, heed_one_interrupt
from .options import (
    BeyondOption,
    DryRunOption,
    EndpointsOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    PresetsOption,
    SetOption,
    WindowOption,
    catalogue,
    library,
)
from .output import must_not_exist, write_json
from .parsing import parse_axis, parse_keys, parse_window
from .progress import interrupted_while, prepare_fit

if TYPE_CHECKING:
    from platform_daemon.engine import AcquisitionJob
    from platform_daemon.schemas import AcquisitionResult


def measure(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    out: Annotated[
        Path | None, typer.Option("--output", "--out", help="Recording to write; needed unless it is a dry run.")
    ] = None,
    shots: Annotated[int, typer.Option(min=0, help="Excited shots.")] = 1,
    blank_shots: Annotated[int, typer.Option(min=0, help="Shots without excitation before them.")] = 0,
    sequence: Annotated[
        str | None, typer.Option(help="Sequence file with the keys that differ from the resonator's preset.")
    ] = None,
    f_tx_hz: Annotated[float | None, typer.Option(help="Excitation frequency, Hz; default: the preset's.")] = None,
    tx_periods: Annotated[int | None, typer.Option(help="Periods of excitation; default: the preset's.")] = None,
    field_ut: Annotated[float | None, typer.Option(help="Excitation field, uT; default: the preset's.")] = None,
    axis: Annotated[str | None, typer.Option(help="x, y, z or a direction as 1,0,0.5; default: the preset's.")] = None,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: the preset's.")] = None,
    pause_s: Annotated[float | None, typer.Option(help="Wait between shots, s; default: the preset's.")] = None,
    drive: DriveOption = None,
    plan_from: Annotated[
        Path | None, typer.Option(help="Plan the drive with the fits in this JSON file, as --json writes them.")
    ] = None,
    per_shot: Annotated[
        list[str] | None,
        typer.Option(help="KEY=FROM:TO:STEP or KEY=A,B,C, shot by shot; several: in lockstep."),
    ] = None,
    dry_run: DryRunOption = False,
    window: WindowOption = "d30",
    variant: Annotated[str | None, typer.Option(help="Model of the on-line fits; default: the resonator's.")] = None,
    models: ModelsOption = None,
    beyond_side_modes: BeyondOption = False,
    presets: PresetsOption = None,
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    comment: Annotated[str, typer.Option(help="Comment for the record.")] = "",
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Measure a series of shots and fit each; every shot is on disk before it counts."""
    plain: dict[str, Any] = {"f_tx_hz": f_tx_hz, "tx_periods": tx_periods, "rx_s": rx_s, "pause_s": pause_s}
    plain |= {
        "field_t": None if field_ut is None else field_ut * 1e-6,
        "axis": None if axis is None else parse_axis(axis),
    }
    keys = _sequence_file(sequence, resonator, force) if sequence else {}
    keys |= {name: value for name, value in plain.items() if value is not None} | parse_keys(drive or [], "--drive")
    asked = {
        "resonator": resonator,
        "shots": shots,
        "blank_shots": blank_shots,
        "sequence": keys if plan_from is None else planned_from(plan_from, keys),
        "window": parse_window(window),
        "variant": variant,
    } | {"sample": sample, "operator": operator, "comment": comment}
    if beyond_side_modes:
        asked["beyond_side_modes"] = True
    if per_shot:
        asked["shot_changes"] = shot_changes(per_shot)
    _series(asked, out, dry_run, json_file, models, (platform, overrides, endpoints, presets), force)


def _series(
    asked: dict[str, Any],
    out: Path | None,
    dry_run: bool,
    json_file: Path | None,
    models: Path | None,
    where: tuple[str, list[str] | None, Path | None, Path | None],
    force: bool,
) -> None:
    """Check it, and unless it is a dry run, measure it.  Raises what ended it, typer.Exit as `measure` does."""
    from platform_daemon.app import start_engine
    from platform_daemon.schemas import AcquisitionRequest
    from platform_daemon.settings import load_platform

    request = validated(AcquisitionRequest, asked, "measure")
    if out is None and not dry_run:
        raise InputError("there is no name for the recording", where="--out", remedy="give --out, or --dry-run")
    must_not_exist(json_file, force, ".json")
    must_not_exist(None if dry_run else out, force, ".h5", ".hdf5", ".mmr")
    heed_one_interrupt()
    platform, overrides, endpoints, presets = where
    engine = start_engine(
        load_platform(platform, overrides or (), endpoints), models=library(models), catalogue=catalogue(presets)
    )
    try:
        plan = engine.plan(request)
        if dry_run or out is None:
            summary = plan.summary()
            print(dry_run_text(summary))
            write_json(json_file, summary)
            return
        prepare_fit()
        job = engine.acquire(plan, out, out.parent, overwrite=force)
        interrupted = interrupted_while(engine, job)
    finally:
        engine.close()
    _conclude(job, out, json_file, interrupted)


def _sequence_file(name: str, resonator: str, force: bool) -> dict[str, Any]:
    """The keys of a sequence file; how many shots is asked for by options.  Raises InputError.

    `force` allows the preset of the other bearing.
    """
    from platform_daemon.schemas import SequencePatch
    from platform_daemon.settings import load_specimen, locate, read_toml, refuse_foreign_preset

    path = locate("sequences", name)
    specimen, _ = load_specimen(resonator)
    if not force:
        remedy = f"leave --sequence out for the preset of the {specimen.variant} bearing, or insist with --force"
        refuse_foreign_preset(path, specimen, f"--sequence {name}", remedy)
    keys = {key: value for key, value in read_toml(path)[0].items() if key not in ("repetitions", "blank_shots")}
    return validated(SequencePatch, keys, str(path)).changes()


def _conclude(job: AcquisitionJob, out: Path, json_file: Path | None, interrupted: bool) -> None:
    """What came out.  Raises what ended it; typer.Exit: 130 interrupted, 3 if no shot can be used."""
    _report_series(job, out, json_file)
    if interrupted:
        raise typer.Exit(INTERRUPTED)
    if job.error is not None:
        raise job.error
    _refuse_unusable(job.result)


def _refuse_unusable(result: AcquisitionResult) -> None:
    """Exit code 3 if shots were fitted and not one gave a result."""
    from platform_daemon.schemas import BLANK

    excited = [] if result.fit is None else [f for f in result.fit.frames if f.reason != BLANK]
    if excited and not any(f.good for f in excited):
        print(f"no shot can be used: {excited[0].reason}", file=sys.stderr)
        raise typer.Exit(3)


def _report_series(job: AcquisitionJob, out: Path, json_file: Path | None) -> None:
    """What came out of a series, also of one that was cut short."""
    from platform_daemon.schemas import SeriesReport

    result = job.result
    for warning in job.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if result.fit is not None:
        print(fit_table_text(result.fit))
    print(f"{result.shots or 0} of {int(job.total)} shots" + ("" if result.file is None else f" in {out}"))
    if result.file is not None:
        report = SeriesReport(file=str(out), recording=result.recording, shots=result.shots, fit=result.fit)
        write_json(json_file, report)

"""`platform-daemon reproduce`: both resonators as in the paper, and its numbers compared with the measured ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import KeptOptions, PlatformOptions, measuring_engine
from platform_daemon.core.command_line.request_options import option_groups

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.features.characterise.schema import CharacteriseRequest


@option_groups
def reproduce(
    *,
    out: Annotated[Path, typer.Option("--output", "--out", help="Folder of the campaign.")] = Path("reproduce"),
    shots: Annotated[int, typer.Option(min=2, max=100_000, help="Shots of each resonator.")] = 100,
    quick: Annotated[bool, typer.Option("--quick", help="10 shots of each, fewer fields; wider tolerances.")] = False,
    thread: Annotated[str, typer.Option(help="Resonator that is the thread; none: it is left out.")] = (
        "thread_published"
    ),
    jewel: Annotated[str, typer.Option(help="Resonator that is the jewel; none: it is left out.")] = "jewel_published",
    tune: Annotated[bool, typer.Option(help="Find f_nat first.")] = True,
    ramp: Annotated[bool, typer.Option(help="Find the field first, 80 % of that of side modes.")] = True,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a folder: what is measured whole stays, the rest is made.")
    ] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check both and show the plans; nothing moves.")] = False,
    kept: KeptOptions,
    where: PlatformOptions,
) -> None:
    """Measure both resonators as in the paper, and compare each of its numbers with the measured one."""
    from platform_daemon import __version__

    from .campaign import begin, characterise_request, check_folder, held_in_n50, is_measured
    from .schema import QUICK_SHOTS, Campaign

    resonators = {v: name for v, name in (("thread", thread), ("jewel", jewel)) if name != "none"}
    if not resonators:
        raise InputError("no resonator is left", where="--thread, --jewel", remedy="name one of them")
    made = QUICK_SHOTS if quick else shots
    campaign = Campaign(
        software_version=__version__,
        platform=str(where.platform),
        changes=tuple(where.overrides or ()),
        shots=made,
        tune=tune,
        ramp=ramp,
        quick=quick,
    )
    if not dry_run:
        check_folder(out, campaign, resume=resume)
    heed_one_interrupt()
    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        todo = {variant: name for variant, name in resonators.items() if not is_measured(out, variant, name)}
        if len(todo) > 1 and not dry_run and not engine.platform.changes_resonators:
            raise InputError(
                "the platform holds one resonator at a time, and does not change it itself",
                where="--thread, --jewel",
                remedy="mount the thread and give --jewel none; then mount the jewel, and continue the folder with "
                "--thread none --resume",
            )
        for variant, name in todo.items():  # before anything is written, or moves
            _check(engine, characterise_request(campaign, variant, name, {}), out)
        if not dry_run:
            begin(out, campaign)
        for variant, name in resonators.items():
            if variant not in todo:
                print(f"{variant}: measured before, {out / f'{variant}.h5'}")
                continue
            made_of = characterise_request(campaign, variant, name, held_in_n50(out, variant))
            _measure(engine, made_of, out / f"{variant}.h5", dry_run=dry_run)
    if not dry_run:
        _report(out, made)


def _check(engine: Engine, request: CharacteriseRequest, out: Path) -> None:
    """Raises InputError for what cannot be made."""
    from platform_daemon.features.procedures.bench import ProcedureBench
    from platform_daemon.features.procedures.conductor import ProcedureFiles
    from platform_daemon.features.procedures.planned import plan_procedure

    plan_procedure(ProcedureBench(engine=engine, files=ProcedureFiles(out, out)), request)


def _measure(engine: Engine, request: CharacteriseRequest, recording: Path, *, dry_run: bool) -> None:
    """Raises InputError, what ended it, typer.Exit."""
    from platform_daemon.core.command_line.recording_target import prepare_target
    from platform_daemon.features.procedures.command import conduct
    from platform_daemon.features.tune.work import NotTuned

    from .campaign import report_files

    prepare_target(recording, force=True, dry_run=dry_run)  # what is there is not whole
    files = report_files(recording)
    conduct(engine, request, recording, None, dry_run=dry_run, overwrite=True, reports=files, unusable=NotTuned)


def _report(folder: Path, shots: int) -> None:
    """Raises PlatformError."""
    from platform_daemon.core.command_line.progress import progress
    from platform_daemon.features.fit.batch.executors import cores, processes

    from .campaign import draws_of
    from .conclusion import conclude
    from .report import claims_text

    with progress() as display:
        claims = conclude(folder, draws_of(shots), processes(cores()), display.tell)
    print(claims_text(claims))
    for name in ("claims.json", "report.html", "report.pdf"):
        print(folder / name)

"""`platform-daemon reproduce`: both resonators as in the paper, and its numbers compared with the measured ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import KeptOptions, PlatformOptions, measuring_engine
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.command_line.request_options import option_groups

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.features.characterise.schema import (
        CharacterisationReport,
        CharacteriseOutcome,
        CharacteriseRequest,
    )
    from platform_daemon.features.characterise.side_by_side.noise_schema import NoiseSweepReport
    from platform_daemon.features.characterise.tables import CharacterisationTask

    from .schema import Campaign

_QUICK_SHOTS = 10
BLANK_SHOTS = 4
"""Before the shots of each, as characterise has it."""
_FITS_PER_LEVEL = 30  # of the noise sweep: of fewer shots several draws of noise
# Of --quick: from 80 % of the paper's field on, as half of it takes twice the shots; steps of 1/20 of that field.
_QUICK_RAMPS = {"thread": {"start_t": 170e-6, "step_t": 10e-6}, "jewel": {"start_t": 390e-6, "step_t": 25e-6}}


@option_groups
def reproduce(
    *,
    out: Annotated[Path, typer.Option("--output", "--out", help="Folder of the campaign.")] = Path("reproduce"),
    shots: Annotated[int, typer.Option(min=2, max=100_000, help="Shots of each resonator.")] = 100,
    quick: Annotated[bool, typer.Option("--quick", help="10 shots of each, fewer fields; wider tolerances.")] = False,
    thread: Annotated[str, typer.Option(help="Resonator that is the thread; none: it is left out.")] = (
        "thread_imperfect"
    ),
    jewel: Annotated[str, typer.Option(help="Resonator that is the jewel; none: it is left out.")] = "jewel_imperfect",
    tune: Annotated[bool, typer.Option(help="Find f_nat and the sequence first.")] = True,
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

    from .schema import Campaign

    resonators = {v: name for v, name in (("thread", thread), ("jewel", jewel)) if name != "none"}
    if not resonators:
        raise InputError("no resonator is left", where="--thread, --jewel", remedy="name one of them")
    made = _QUICK_SHOTS if quick else shots
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
        _prepare(out, campaign, resume=resume)
    heed_one_interrupt()
    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        for variant, name in resonators.items():
            if (out / f"{variant}.h5").is_file() and outcome_in(out, variant, of=name) is not None:
                print(f"{variant}: measured before, {out / f'{variant}.h5'}")
                continue
            made_of = characterise_request(campaign, variant, name, _held(out, variant))
            _measure(engine, made_of, out / f"{variant}.h5", dry_run=dry_run)
    if not dry_run:
        report_on(out, draws=max(1, round(_FITS_PER_LEVEL / made)))


def _prepare(out: Path, campaign: Campaign, *, resume: bool) -> None:
    """Raises InputError for a folder that holds something else, or a campaign of another version or request."""
    from pydantic import ValidationError

    from .schema import Campaign

    file = out / "campaign.json"
    if not resume:
        if out.is_file():
            raise InputError("is a file", where=str(out), remedy="name a folder")
        if out.is_dir() and any(out.iterdir()):
            raise InputError("the folder is not empty", where=str(out), remedy="name another one, or give --resume")
        out.mkdir(parents=True, exist_ok=True)
        write_json(file, campaign)
        return
    try:
        before = Campaign.model_validate_json(file.read_bytes())
    except (OSError, ValidationError):
        remedy = "name the folder of one, or leave --resume out"
        raise InputError("there is no campaign to continue", where=str(file), remedy=remedy) from None
    if before != campaign:
        named = [name for name in type(campaign).model_fields if getattr(before, name) != getattr(campaign, name)]
        why = "; ".join(f"{n}: {getattr(before, n)} there, {getattr(campaign, n)} now" for n in named)
        remedy = "continue it as it was begun, or begin a new folder"
        raise InputError("the campaign was begun differently", where=str(file), why=why, remedy=remedy)


def _held(out: Path, variant: str) -> dict[str, float]:
    """What N50 holds: for the jewel the thread's lambda of D30 (ssec:analysis_of_measurement_data), if it is known."""
    thread = outcome_in(out, "thread") if variant == "jewel" else None
    found = None if thread is None else thread.report.d30.parameters.get("lambda_per_s")
    return {} if found is None else {"lambda_per_s": found.mean}


def characterise_request(
    campaign: Campaign, variant: str, resonator: str, held: dict[str, float]
) -> CharacteriseRequest:
    """Of one resonator; held: in its N50 fits.  Raises InputError."""
    from drivers.validation import validated
    from platform_daemon.features.characterise.schema import CharacteriseRequest

    keys = {
        "kind": "characterise",
        "acquisition": {"resonator": resonator, "shots": campaign.shots, "blank_shots": BLANK_SHOTS},
        "held_in_n50": held,
        "tune": campaign.tune,
        "ramp": None if not campaign.ramp else _QUICK_RAMPS[variant] if campaign.quick else {},
    }
    return validated(CharacteriseRequest, keys, "reproduce")


def _measure(engine: Engine, request: CharacteriseRequest, recording: Path, *, dry_run: bool) -> None:
    """Raises InputError, what ended it, typer.Exit."""
    from platform_daemon.core.command_line.recording_target import prepare_target
    from platform_daemon.features.procedures.bench import ReportFiles
    from platform_daemon.features.procedures.command import conduct
    from platform_daemon.features.tune.work import NotTuned

    prepare_target(recording, force=True, dry_run=dry_run)  # what is there is not whole
    files = ReportFiles(report=recording.with_suffix(".json"), html=recording.with_suffix(".html"))
    conduct(engine, request, recording, None, dry_run=dry_run, overwrite=True, reports=files, unusable=NotTuned)


def outcome_in(folder: Path, variant: str, *, of: str | None = None) -> CharacteriseOutcome | None:
    """What a resonator's procedure has found; None: it was not made, or did not come to its end.

    of: the resonator that is meant.  Raises InputError for a log that another version wrote, and of another resonator.
    """
    from pydantic import ValidationError

    from platform_daemon import __version__
    from platform_daemon.features.characterise.schema import CharacteriseOutcome
    from platform_daemon.features.procedures.schema import ProcedureLog

    file = folder / f"{variant}.h5.log.json"
    if not file.is_file():
        return None
    remedy = "measure again into another folder"
    try:
        log = ProcedureLog.model_validate_json(file.read_bytes())
    except ValidationError:
        raise InputError("is no log of a procedure of this version", where=str(file), remedy=remedy) from None
    if log.software_version != __version__:
        why = f"{log.software_version} wrote it, this is {__version__}"
        raise InputError("was written by another version", where=str(file), why=why, remedy=remedy)
    there = log.request.acquisition.resonator
    if of is not None and there != of:
        remedy = f"give --{variant} {there}, or begin a new folder"
        raise InputError(f"is of {there}, not of {of}", where=str(file), remedy=remedy)
    return log.result.outcome if isinstance(log.result.outcome, CharacteriseOutcome) else None


def report_on(folder: Path, *, draws: int) -> None:
    """Add noise to the shots of both, write the report, and print the table of claims.

    draws: of noise for each shot and level.  What a sweep has made before stays.  Raises PlatformError.
    """
    from .claims import claims_of
    from .findings import Findings
    from .folder import write_claims
    from .report import claims_text

    outcomes = {v: found for v in ("thread", "jewel") if (found := outcome_in(folder, v)) is not None}
    reports = {variant: found.report for variant, found in outcomes.items()}
    tasks = {variant: _task(folder / f"{variant}.h5", report) for variant, report in reports.items()}
    noise, why = _swept(folder, tasks, reports, draws)
    claims = claims_of(Findings(outcomes, noise, why))
    write_claims(folder, claims, tasks, reports, noise)
    print(claims_text(claims))
    for name in ("claims.json", "report.html", "report.pdf"):
        print(folder / name)


def _task(recording: Path, report: CharacterisationReport) -> CharacterisationTask:
    """Of the shots that were reported on.  Raises InputError, RecordingError."""
    from platform_daemon.features.characterise.tables import characterisation_task
    from platform_daemon.features.fit.fit_request import FitSettings

    frames = tuple(fit.frame for fit in report.d30_fits.frames)
    return characterisation_task(recording, FitSettings(frames=frames), report.n50.held, report.alpha)


def _swept(
    folder: Path, tasks: dict[str, CharacterisationTask], reports: dict[str, CharacterisationReport], draws: int
) -> tuple[NoiseSweepReport | None, str]:
    """The sweep, or why there is none.  Raises PlatformError."""
    from platform_daemon.core.command_line.progress import progress
    from platform_daemon.features.characterise.side_by_side.sweep import (
        HIGHEST_AM2_PER_S,
        PARTS,
        NoiseOptions,
        sweep_of,
        swept,
    )
    from platform_daemon.features.fit.batch.executors import cores, processes

    if len(tasks) < 2:
        return None, "only one of the resonators was measured in this campaign"
    options = NoiseOptions(None, HIGHEST_AM2_PER_S, draws)
    try:
        made = sweep_of(list(tasks.values()), list(reports.values()), options)
    except InputError as error:  # no calibration, or no shot with a fit: the campaign has the rest of its numbers
        return None, str(error)
    with progress() as display:
        found = swept(folder / PARTS, made, list(reports.values()), options, processes(cores()), display.tell)
    write_json(folder / "noise.json", found)
    return found, ""

"""`platform-daemon characterise`: the paper's tables and figures of one resonator, from many shots."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.interrupts import end_at_once, heed_one_interrupt
from platform_daemon.core.command_line.options import (
    CalibrationOption,
    FramesOption,
    HtmlOption,
    KeptOptions,
    PlatformOptions,
    StepOption,
    TableOptions,
    TermOption,
    VariantOption,
    calibration_in,
    measuring_engine,
)
from platform_daemon.core.command_line.output import must_not_exist, write_json, write_page
from platform_daemon.core.command_line.recording_target import prepare_target
from platform_daemon.core.command_line.request_fields import REQUEST_FIELDS, Limits
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups
from platform_daemon.features.models.options import variant_named

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.models.resolve import ModelChoice
    from platform_daemon.features.procedures.schema import ProcedureResult

    from .schema import CharacterisationReport
    from .side_by_side.sweep import NoiseOptions
    from .tables import CharacterisationTask


SHOTS = offers(
    "CharacteriseRequest",
    "acquisition.resonator",
    "acquisition.preset",
    "acquisition.shots",
    "acquisition.blank_shots",
    "acquisition.sequence.field_ut",
    "acquisition.sequence.rx_s",
    "acquisition.sequence.pause_s",
    "acquisition.sample",
    "acquisition.operator",
    "acquisition.comment",
    changes={
        "acquisition.resonator": {
            "help": "Measure this one: thread, jewel, or a resonator file.",
            "required": False,
        },
        "acquisition.shots": {"default": 100, "limits": Limits(low=1, high=1_000_000)},
        "acquisition.blank_shots": {"default": 4},
    },
)
SourceOption = Annotated[
    list[Path] | None,
    typer.Option("--from", help="Or a recording with the shots of one resonator; several: each by itself."),
]
CompareOption = Annotated[
    tuple[Path, Path] | None,
    typer.Option("--compare", help="Or two recordings, one specimen each, side by side in the folder --out."),
]
OutOption = Annotated[
    Path | None,
    typer.Option("--output", "--out", help="Recording to write, characterise.h5; of --compare a folder, compare."),
]
DryRunOption = Annotated[bool, typer.Option("--dry-run", help="Check the shots and show the plan; nothing moves.")]
_ALPHA: float = REQUEST_FIELDS["CharacteriseRequest"]["alpha"].default


@dataclass(frozen=True, kw_only=True)
class ProcedureOptions:
    """What is done before the shots are made."""

    tune: Annotated[bool, typer.Option(help="Find f_nat and the sequence first.")] = True
    ramp: Annotated[
        bool | None, typer.Option(help="Find the field first, 80 % of that of side modes; default: unless --field-ut.")
    ] = None
    max_ut: Annotated[float | None, typer.Option(help="Field that the ramp does not pass, uT.")] = None

    def refuse(self, acquisition: Keys) -> None:
        """Raises InputError for an option that shots which were made already cannot have."""
        usual = {"shots": 100, "blank_shots": 4}
        changed = [key for key, value in acquisition.items() if value and value != usual.get(key)]
        given = {"--no-tune": self.tune is False, "--ramp": self.ramp is not None, "--max-ut": self.max_ut is not None}
        of_sequence = "--field-ut, --rx-s, --pause-s"
        named = [of_sequence if key == "sequence" else f"--{key.replace('_', '-')}" for key in changed]
        named += [name for name, there in given.items() if there]
        if named:
            what, remedy = "goes with shots that are made now", "leave it out, or name a resonator in place of --from"
            raise InputError(what, where=named[0], remedy=remedy)

    def keys(self, acquisition: Keys) -> Keys:
        """As the request has them, whose shots are made as `acquisition` says."""
        ramps = "field_t" not in acquisition.get("sequence", {}) if self.ramp is None else self.ramp
        limits = {"max_t": None if self.max_ut is None else 1e-6 * self.max_ut}
        return {"tune": self.tune, "ramp": limits if ramps else None}


@dataclass(frozen=True, kw_only=True)
class RecordingOptions:
    """How the shots of a recording are fitted."""

    frames: FramesOption = None
    step: StepOption = None
    term: TermOption = None
    calibration: CalibrationOption = None

    def settings(self, model: ModelChoice | None) -> FitSettings:
        """How any of them is fitted.  Raises InputError."""
        from platform_daemon.core.command_line.parsing import parse_frames
        from platform_daemon.features.fit.fit_request import FitSettings

        return FitSettings(
            model,
            calibration=calibration_in(self.calibration),
            terms=tuple(self.term or ()),
            frames=None if self.frames is None else parse_frames(self.frames),
            step=self.step,
        )

    def refuse(self) -> None:
        """Raises InputError for an option that shots which are still to be made cannot have."""
        given = {
            "--frames": self.frames,
            "--step": self.step,
            "--with-term": self.term,
            "--calibration": self.calibration,
        }
        for name in (name for name, value in given.items() if value is not None):
            raise InputError("goes with a recording", where=name, remedy="measure first, then give it with --from")


@dataclass(frozen=True, kw_only=True)
class ReportOptions(TableOptions):
    """What the report compares, and the files that it is written to."""

    hold: Annotated[
        list[str] | None, typer.Option("--hold", help="Hold the loss NAME=VALUE in N50; default: lambda, of D30.")
    ] = None
    alpha: Annotated[float, typer.Option(min=1e-12, max=0.5, help="Level of significance.")] = _ALPHA
    html: HtmlOption = None

    @property
    def held(self) -> dict[str, float] | None:
        """What N50 holds; None: lambda, of D30.  Raises InputError."""
        from platform_daemon.core.command_line.parsing import parse_values

        return parse_values(self.hold, "--hold") if self.hold else None

    def check(self) -> None:
        """Raises InputError for a value or a file that cannot be."""
        assert self.held is None or self.held
        super().check()
        must_not_exist(self.html, self.force, ".html", ".htm")


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """White noise that is added to the recorded shots of two specimens."""

    noise: Annotated[
        str | None, typer.Option("--noise", metavar="FROM:TO", help="Add noise at 30 levels, A m2/s, as 0.03:1.5.")
    ] = None
    draws: Annotated[int, typer.Option(min=1, max=1000, help="Draws of noise for each shot and level.")] = 1
    shard: Annotated[
        str | None, typer.Option("--shard", metavar="I/N", help="Make this share of the noise fits only, as 3/8.")
    ] = None
    merge: Annotated[bool, typer.Option("--merge", help="Only put the noise fits of all shards together.")] = False
    dask: Annotated[str | None, typer.Option("--dask", metavar="ADDRESS", help="Noise fits on this cluster.")] = None

    def asked(self) -> NoiseOptions | None:
        """None: no noise.  Raises InputError."""
        from .side_by_side.sweep import NoiseOptions, parse_levels, parse_shard

        if self.noise is None:
            given = {"--shard": self.shard, "--merge": self.merge or None, "--dask": self.dask}
            for name in (name for name, value in given.items() if value is not None):
                raise InputError("belongs to a noise sweep", where=name, remedy="give --noise FROM:TO too")
            return None
        if self.shard is not None and self.merge:
            raise InputError("exclude each other", where="--shard, --merge", remedy="merge once all shards are made")
        low, high = parse_levels(self.noise)
        shard = None if self.shard is None else parse_shard(self.shard)
        return NoiseOptions(low, high, self.draws, shard=shard, merge=self.merge)


@option_groups
def characterise(
    *,
    shots: Annotated[Keys, SHOTS],
    source: SourceOption = None,
    compare: CompareOption = None,
    out: OutOption = None,
    dry_run: DryRunOption = False,
    variant: VariantOption = None,
    kept: KeptOptions,
    procedure: ProcedureOptions,
    recording: RecordingOptions,
    report: ReportOptions,
    sweep: SweepOptions,
    where: PlatformOptions,
) -> None:
    """Fit many shots over N50 and D30: tables and figures of the paper, and whether the two windows agree.

    Either of shots that are made now (--resonator), of a recording (--from), or of two side by side (--compare).
    """
    acquisition = shots["acquisition"]
    sources = list(dict.fromkeys(source or []))
    if sum(("resonator" in acquisition, bool(sources), compare is not None)) != 1:
        remedy = "name a resonator to measure, a recording, or two to compare"
        raise InputError("give one of the three", where="--resonator, --from, --compare", remedy=remedy)
    asked = sweep.asked()
    if asked is not None and compare is None:
        remedy = "name two recordings with --compare"
        raise InputError("noise is added to two recordings", where="--noise", remedy=remedy)
    report.check()
    heed_one_interrupt()
    if sources:
        procedure.refuse(acquisition)
        _of_recordings(sources, variant_named(variant, kept.models), recording, report)
        return
    if compare is not None:
        folder = out or Path("compare")
        _compare(compare, folder, variant_named(variant, kept.models), recording, report, asked, sweep.dask)
        return
    recording.refuse()
    request = {"acquisition": {**acquisition, "variant": variant}, **procedure.keys(acquisition)}
    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        _of_resonator(engine, request, out or Path("characterise.h5"), report, dry_run=dry_run)


def _of_resonator(engine: Engine, request: Keys, out: Path, wanted: ReportOptions, *, dry_run: bool) -> None:
    """Raises InputError, and what `conduct` raises."""
    from drivers.validation import validated
    from platform_daemon.features.procedures.bench import ReportFiles
    from platform_daemon.features.procedures.command import conduct
    from platform_daemon.features.tune.work import NotTuned

    from .schema import CharacteriseRequest

    prepare_target(out, force=wanted.force, dry_run=dry_run)
    keys = {"kind": "characterise", "held_in_n50": wanted.held or {}, "alpha": wanted.alpha, **request}
    conduct(
        engine,
        validated(CharacteriseRequest, keys, "characterise"),
        out,
        wanted.json_file if dry_run else None,
        dry_run=dry_run,
        csv_file=wanted.csv_file if dry_run else None,
        overwrite=wanted.force,
        reports=ReportFiles(report=wanted.json_file, html=wanted.html),
        unusable=NotTuned,
        write=lambda result: _write_table(result, wanted.csv_file),
        report=lambda result: _print_outcome(result, wanted.html),
    )


def _write_table(result: ProcedureResult, csv_file: Path | None) -> None:
    from .report import parameter_rows
    from .schema import CharacteriseOutcome

    if isinstance(result.outcome, CharacteriseOutcome):
        write_csv(csv_file, parameter_rows(result.outcome.report))


def _print_outcome(result: ProcedureResult, html: Path | None) -> None:
    """What tune, ramp and the shots have brought; the page is written already."""
    from platform_daemon.features.ramp.report import ramp_text
    from platform_daemon.features.tune.report import outcome_text

    from .report import characterisation_text
    from .schema import CharacteriseOutcome

    if not isinstance(result.outcome, CharacteriseOutcome):
        return
    if result.outcome.tune is not None:
        print(outcome_text(result.outcome.tune))
    if result.outcome.ramp is not None:
        print(ramp_text(result.outcome.ramp))
    print(characterisation_text(result.outcome.report))
    if html is not None:
        print(html)


def _of_recordings(
    sources: list[Path], model: ModelChoice | None, options: RecordingOptions, wanted: ReportOptions
) -> None:
    """Each by itself, all checked first.  Raises InputError, RecordingError, typer.Exit: 3 if one has no fit."""
    from .tables import characterisation_task

    if len(sources) > 1 and wanted.html is not None:
        remedy = "name one recording with --from, or leave --html out"
        raise InputError("a page shows one recording", where="--html", remedy=remedy)
    settings = options.settings(model)
    try:
        _fit_all([characterisation_task(each, settings, wanted.held, wanted.alpha) for each in sources], wanted)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()


def _compare(
    sources: tuple[Path, Path],
    folder: Path,
    model: ModelChoice | None,
    options: RecordingOptions,
    wanted: ReportOptions,
    noise: NoiseOptions | None,
    dask: str | None,
) -> None:
    """Raises InputError, RecordingError, PlatformError."""
    from platform_daemon.core.command_line.progress import progress
    from platform_daemon.features.fit.fit_files import batch_workers

    from .report import characterisation_text
    from .side_by_side.compare import break_even_text, write_comparison
    from .side_by_side.sweep import PARTS, named, sweep_of, swept
    from .tables import characterisation_task

    if folder.is_file():
        raise InputError("is a file", where=str(folder), remedy="name a folder with --out")
    settings = options.settings(model)
    names = named(sources)
    found = [characterisation_task(path, settings, wanted.held, wanted.alpha) for path in sources]
    try:
        reports = [_fitted(task) for task in found]
        told = None
        if noise is not None:
            swept_over = sweep_of(found, reports, noise)
            with progress() as display:
                workers = batch_workers(sources, settings, processes=None, dask=dask)
                told = swept(folder / PARTS, swept_over, reports, noise, workers, display.tell)
            if told is None:
                print(f"shard {noise.shard}: its parts are in {folder / PARTS}")
                return
        pairs = dict(zip(names, reports, strict=True))
        write_comparison(folder, dict(zip(names, found, strict=True)), pairs, told)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()
    for name, report in pairs.items():
        print(f"{name}:\n{characterisation_text(report)}")
    for crossing in () if told is None else told.break_even:
        print(break_even_text(crossing, names))
    print(folder / "report.html")


def _fit_all(tasks: list[CharacterisationTask], wanted: ReportOptions) -> None:
    """Fit with a bar, write the files, print the tables.  Raises typer.Exit: 3 if no shot of one of them has a fit."""
    from .report import characterisation_text, parameter_rows
    from .schema import CharacterisationBatch

    reports = tuple(_fitted(task) for task in tasks)
    write_json(wanted.json_file, reports[0] if len(tasks) == 1 else CharacterisationBatch(files=reports))
    write_csv(wanted.csv_file, (row for report in reports for row in parameter_rows(report)))
    if wanted.html is not None:
        from .page import characterisation_html
        from .tables import shown_shot

        write_page(wanted.html, characterisation_html(reports[0], shown_shot(tasks[0], reports[0])))
    for task, report in zip(tasks, reports, strict=True):
        if len(tasks) > 1:
            print(f"{task.path}:")
        print(characterisation_text(report))
    if wanted.html is not None:
        print(wanted.html)
    refused = [each.file for each in reports if not (each.n50.good or each.d30.good)]
    if refused:
        place = f"{', '.join(refused)}: " if len(tasks) > 1 else ""
        print(f"{place}every shot was refused in both windows", file=sys.stderr)
        raise typer.Exit(3)


def _fitted(task: CharacterisationTask) -> CharacterisationReport:
    from platform_daemon.core.command_line.progress import prepare_fit, progress
    from platform_daemon.features.fit.fit_files import workers_for

    from .tables import characterise as fit_and_tell

    prepare_fit()  # or the time of the first fit would be that of compiling
    with progress() as display, workers_for(task.frames) as workers:
        return fit_and_tell(task, workers, display.tell)

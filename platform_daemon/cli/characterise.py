"""`platform-daemon characterise`: the paper's tables and figures of one resonator, from many shots."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
from drivers.validation import validated
from platform_daemon.schemas import SIGNIFICANCE

from .interrupts import end_at_once, heed_one_interrupt
from .options import (
    CalibrationOption,
    EndpointsOption,
    ForceOption,
    FramesOption,
    HtmlOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    SetOption,
    TermOption,
    VariantOption,
    calibration_in,
    catalogue,
    library,
    variant_named,
)
from .output import keep_page, must_not_exist, write_json
from .procedure import conduct
from .progress import prepare_fit, progress

if TYPE_CHECKING:
    from platform_daemon.analysis import CharacterisationTask, ModelChoice
    from platform_daemon.engine import Engine
    from platform_daemon.schemas import CharacterisationReport, ProcedureResult


ResonatorOption = Annotated[str | None, typer.Option(help="Measure this one: thread, jewel, or a resonator file.")]
SourceOption = Annotated[Path | None, typer.Option("--from", help="Or a recording with the shots of one resonator.")]
OutOption = Annotated[Path, typer.Option("--output", "--out", help="Recording to write.")]
DryRunOption = Annotated[bool, typer.Option("--dry-run", help="Check the shots and show the plan; nothing moves.")]
TuneOption = Annotated[bool, typer.Option(help="Find f_nat and the sequence first.")]
RampOption = Annotated[
    bool | None, typer.Option(help="Find the field first, 80 % of that of side modes; default: unless --field-ut.")
]
HoldOption = Annotated[
    list[str] | None, typer.Option("--hold", help="Hold the loss NAME=VALUE in N50; default: lambda, of D30.")
]


@dataclass(frozen=True)
class _Wanted:
    """What is made of the shots: what N50 holds, the level of significance, files to write, over others if `force`."""

    held: dict[str, float] | None
    alpha: float
    json_file: Path | None
    html: Path | None
    force: bool

    def check(self) -> None:
        """Raises InputError for a file that cannot be written."""
        must_not_exist(self.json_file, self.force, ".json")
        must_not_exist(self.html, self.force, ".html", ".htm")


def characterise(
    resonator: ResonatorOption = None,
    source: SourceOption = None,
    shots: Annotated[int, typer.Option(min=1, help="Excited shots.")] = 100,
    tune: TuneOption = True,
    ramp: RampOption = None,
    max_ut: Annotated[float | None, typer.Option(help="Field that the ramp does not pass, uT.")] = None,
    blank_shots: Annotated[int, typer.Option(min=0, help="Shots without excitation before them.")] = 4,
    field_ut: Annotated[float | None, typer.Option(help="Excitation field, uT; default: the preset's.")] = None,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: the preset's.")] = None,
    pause_s: Annotated[float | None, typer.Option(help="Wait between shots, s; default: the preset's.")] = None,
    out: OutOption = Path("characterise.h5"),
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    comment: Annotated[str, typer.Option(help="Comment for the record.")] = "",
    dry_run: DryRunOption = False,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    frames: FramesOption = None,
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    calibration: CalibrationOption = None,
    hold: HoldOption = None,
    alpha: Annotated[float, typer.Option(min=1e-12, max=0.5, help="Level of significance.")] = SIGNIFICANCE,
    json_file: JsonOption = None,
    html: HtmlOption = None,
    force: ForceOption = False,
) -> None:
    """Fit many shots over N50 and D30: tables and figures of the paper, and whether the two windows agree.

    Either of shots that are made now (--resonator), or of a recording (--from).
    """
    from .parsing import parse_values

    if (resonator is None) == (source is None):
        remedy = "name a resonator to measure, or a recording"
        raise InputError("give one of the two", where="--resonator, --from", remedy=remedy)
    wanted = _Wanted(parse_values(hold, "--hold") if hold else None, alpha, json_file, html, force)
    wanted.check()
    heed_one_interrupt()
    of_recordings = {"--frames": frames, "--with-term": term, "--calibration": calibration}
    if source is not None:
        _of_recording(source, variant_named(variant, models), of_recordings, wanted)
        return
    for name in (name for name, value in of_recordings.items() if value is not None):
        raise InputError("goes with a recording", where=name, remedy="measure first, then give it with --from")
    sequence = {"field_t": None if field_ut is None else field_ut * 1e-6, "rx_s": rx_s, "pause_s": pause_s}
    shot = {"sequence": {name: value for name, value in sequence.items() if value is not None}, "variant": variant}
    series = {"resonator": resonator, "shots": shots, "blank_shots": blank_shots, **shot}
    said = {"sample": sample, "operator": operator, "comment": comment}
    ramps = field_ut is None if ramp is None else ramp
    limits = {"max_t": None if max_ut is None else 1e-6 * max_ut} if ramps else None
    asked = {"acquisition": {**series, **said}, "tune": tune, "ramp": limits}
    with _engine(platform, overrides, endpoints, models) as engine:
        _of_resonator(engine, asked, out, wanted, dry_run=dry_run)


@contextmanager
def _engine(
    platform: str, overrides: list[str] | None, endpoints: Path | None, models: Path | None
) -> Iterator[Engine]:
    from platform_daemon.app import start_engine
    from platform_daemon.settings import load_platform

    engine = start_engine(
        load_platform(platform, overrides or (), endpoints), models=library(models), catalogue=catalogue(None)
    )
    try:
        yield engine
    finally:
        engine.close()


def _of_resonator(engine: Engine, asked: dict[str, Any], out: Path, wanted: _Wanted, *, dry_run: bool) -> None:
    """Raises InputError, and what `conduct` raises."""
    from platform_daemon.engine import CharacterisationFiles
    from platform_daemon.reports import characterisation_html, characterisation_text, outcome_text, ramp_text
    from platform_daemon.schemas import CharacteriseOutcome, CharacteriseRequest

    def tell(result: ProcedureResult) -> None:
        if isinstance(result.outcome, CharacteriseOutcome):
            if result.outcome.tune is not None:
                print(outcome_text(result.outcome.tune))
            if result.outcome.ramp is not None:
                print(ramp_text(result.outcome.ramp))
            print(characterisation_text(result.outcome.report))
            if wanted.html is not None:
                print(wanted.html)

    must_not_exist(None if dry_run else out, wanted.force, ".h5", ".hdf5", ".mmr")
    known = {"kind": "characterise", "held_in_n50": wanted.held or {}, "alpha": wanted.alpha}
    request = validated(CharacteriseRequest, asked | known, "characterise")
    tables = CharacterisationFiles(characterisation_html, report=wanted.json_file, html=wanted.html)
    conduct(
        engine,
        request,
        out,
        wanted.json_file if dry_run else None,
        dry_run=dry_run,
        overwrite=wanted.force,
        tables=tables,
        tell=tell,
    )


def _of_recording(source: Path, model: ModelChoice | None, options: dict[str, Any], wanted: _Wanted) -> None:
    """options: frames, further terms and calibration, by their name on the command line."""
    from platform_daemon.analysis import FitSettings, characterisation_task

    from .parsing import parse_frames

    frames = options["--frames"]
    settings = FitSettings(
        model,
        calibration=calibration_in(options["--calibration"]),
        terms=tuple(options["--with-term"] or ()),
        frames=None if frames is None else parse_frames(frames),
    )
    try:
        _tell(characterisation_task(source, settings, wanted.held, wanted.alpha), wanted.json_file, wanted.html)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        end_at_once()


def _tell(task: CharacterisationTask, json_file: Path | None, html: Path | None) -> None:
    """Fit with a bar, print the tables, write what was asked for.  Raises typer.Exit: 3 if no shot has a fit."""
    from platform_daemon.reports import characterisation_text

    report = _fitted(task)
    print(characterisation_text(report))
    write_json(json_file, report)
    if html is not None:
        from platform_daemon.analysis import shown_shot
        from platform_daemon.reports import characterisation_html

        keep_page(html, characterisation_html(report, shown_shot(task, report)))
    if not (report.n50.good or report.d30.good):
        print("every shot was refused in both windows", file=sys.stderr)
        raise typer.Exit(3)


def _fitted(task: CharacterisationTask) -> CharacterisationReport:
    from platform_daemon.analysis import characterise as fit_and_tell

    from .fit import workers_for

    prepare_fit()  # or the time of the first fit would be that of compiling
    with progress() as display, workers_for(task.frames) as workers:
        return fit_and_tell(task, workers, display.tell)

"""`platform-daemon fit`: one or many recordings, on all cores or on a cluster."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError, PlatformError
from platform_daemon import analysis
from platform_daemon.reports import fit_line, fit_table_text
from platform_daemon.schemas import FileError, FitBatch, FitReport

from .interrupts import end_at_once, heed_one_interrupt
from .options import (
    CalibrationOption,
    FixOption,
    ForceOption,
    FramesOption,
    JsonOption,
    ModelsOption,
    TermOption,
    VariantOption,
    WindowOption,
    calibration_in,
    variant_named,
)
from .output import must_not_exist, write_json
from .progress import progress

if TYPE_CHECKING:
    from platform_daemon.analysis import FitSettings, Ledger, WorkerPool

_TOLD = 2  # files whose refusals are told at the end
_FEW_FRAMES = 16  # are fitted before other processes have started


def fit(
    files: Annotated[list[Path], typer.Argument(help="Recordings.")],
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    window: WindowOption = "d30",
    calibration: CalibrationOption = None,
    frames: FramesOption = None,
    fix: FixOption = None,
    hint: Annotated[
        list[str] | None, typer.Option("--hint", help="Hold the loss NAME=VALUE where the window cannot tell it.")
    ] = None,
    derived: Annotated[bool, typer.Option("--derived", help="Q, equivalent Q, orientation errors, Allan.")] = False,
    json_file: JsonOption = None,
    jsonl: Annotated[Path | None, typer.Option("--jsonl", help="Append each finished file as a line.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Leave out files that --jsonl holds already.")] = False,
    processes: Annotated[int | None, typer.Option(min=1, help="Processes; default: one per core.")] = None,
    dask: Annotated[str | None, typer.Option("--dask", metavar="ADDRESS", help="Fit on this Dask cluster.")] = None,
    force: ForceOption = False,
) -> None:
    """Fit the frames of one or more recordings."""
    from platform_daemon.analysis import FitSettings

    from .parsing import parse_frames, parse_values, parse_window

    other = calibration_in(calibration)
    fixed, hints = parse_values(fix or [], "--fix"), parse_values(hint or [], "--hint")
    settings = FitSettings(
        variant_named(variant, models), parse_window(window), fixed, other, derived, hints, tuple(term or ()),
        None if frames is None else parse_frames(frames),
    )  # fmt: skip
    must_not_exist(json_file, force, ".json")
    _check_ledger(jsonl, resume, force)
    heed_one_interrupt()
    with ExitStack() as stack:
        results = _Results(files, _ledger(stack, jsonl, settings, resume))
        try:
            if results.todo:
                workers = stack.enter_context(_workers(results.todo, settings, processes, dask))
                _fit_all(results, settings, workers)
        except KeyboardInterrupt:
            _tell_interrupted(results, json_file)
            end_at_once()
    _end(results, json_file)


def _check_ledger(jsonl: Path | None, resume: bool, force: bool) -> None:
    """Raises InputError if --jsonl and --resume do not go together with what there is."""
    if resume and jsonl is None:
        raise InputError("nothing to go on from", where="--resume", remedy="name the file of the last run with --jsonl")
    must_not_exist(jsonl, force or resume, ".jsonl")


def _ledger(stack: ExitStack, jsonl: Path | None, settings: FitSettings, resume: bool) -> Ledger | None:
    from platform_daemon.analysis import Ledger

    return None if jsonl is None else stack.enter_context(Ledger(jsonl, settings, resume=resume))


def _workers(
    files: list[Path], settings: FitSettings, processes: int | None, dask: str | None
) -> AbstractContextManager[WorkerPool]:
    """Where to fit: the cluster, this process for few frames, else a process per core."""
    if dask is not None:
        return analysis.dask_cluster(dask, files[0])
    return workers_for(_FEW_FRAMES + 1 if _many_frames(files, settings) else 0, processes)


def workers_for(frames: int, processes: int | None = None) -> AbstractContextManager[WorkerPool]:
    """This process for few frames, else a process per core, or as many as asked for."""
    count = processes or analysis.cores()
    return analysis.in_this_process() if count == 1 or frames <= _FEW_FRAMES else analysis.processes(count)


def _many_frames(files: list[Path], settings: FitSettings) -> bool:
    from platform_daemon.analysis import InputFile, count_frames

    frames = 0
    for path in files[:_FEW_FRAMES]:
        try:
            frames += count_frames(InputFile(path), settings)
        except PlatformError:  # said when its turn comes
            continue
        if frames > _FEW_FRAMES:
            return True
    return len(files) > _FEW_FRAMES


class _Results:
    """What has come out so far; told as it comes."""

    def __init__(self, files: list[Path], ledger: Ledger | None) -> None:
        self.files = list(dict.fromkeys(files))
        self._ledger = ledger
        self._ended: dict[Path, FitReport | PlatformError] = {}
        for path in self.files:
            report = None if ledger is None else ledger.finished(path)
            if report is not None:
                self._ended[path] = report
                self._say(path, "finished before")

    @property
    def todo(self) -> list[Path]:
        """Files that have not ended."""
        return [path for path in self.files if path not in self._ended]

    @property
    def errors(self) -> list[PlatformError]:
        """Of the files that could not be fitted."""
        return [e for e in self._ended.values() if isinstance(e, PlatformError)]

    @property
    def any_good(self) -> bool:
        """Is there a good frame?"""
        return any(r.good_frames for r in self._ended.values() if not isinstance(r, PlatformError))

    @property
    def why_refused(self) -> str:
        """What was wrong with the first frame of the first files, in one line."""
        reports = [(path, r) for path, r in self._ended.items() if isinstance(r, FitReport) and r.frames]
        told = [
            f"{path}: frame {r.frames[0].frame}: {r.frames[0].reason}" if len(self.files) > 1
            else f"frame {r.frames[0].frame}: {r.frames[0].reason}"
            for path, r in reports[:_TOLD]
        ]  # fmt: skip
        return "; ".join(told)

    def add(self, path: Path, outcome: FitReport | PlatformError, left: str) -> None:
        """A file has ended: keep it, tell it."""
        self._ended[path] = outcome
        if self._ledger is not None:
            self._ledger.add(path, outcome)
        self._say(path, left)

    def _say(self, path: Path, left: str) -> None:
        outcome = self._ended[path]
        if len(self.files) == 1:  # its error ends the program
            if not isinstance(outcome, PlatformError):
                print(fit_table_text(outcome), flush=True)
            return
        place = f"[{len(self._ended)}/{len(self.files)}] {path}"
        if isinstance(outcome, PlatformError):
            print(f"{place}: error: {outcome}", file=sys.stderr, flush=True)
        else:
            print(f"{place}: {fit_line(outcome)} ({left})", flush=True)

    def content(self) -> FitReport | FitBatch | None:
        """For --json: the report of the one file, or all of them; None if no file has ended."""
        if not self._ended:
            return None
        entries = tuple(_entry(path, self._ended[path]) for path in self.files if path in self._ended)
        if len(self.files) == 1 and isinstance(entries[0], FitReport):
            return entries[0]
        return FitBatch(files=entries, unfinished=tuple(map(str, self.todo)) or None)


def _entry(path: Path, outcome: FitReport | PlatformError) -> FitReport | FileError:
    if isinstance(outcome, PlatformError):
        return FileError(file=str(path), error=analysis.error_summary(outcome))
    return outcome


def _tell_interrupted(results: _Results, json_file: Path | None) -> None:
    """What has ended is kept, and names what has not; where nothing has, nothing is written."""
    write_json(json_file, results.content())
    done, files = len(results.files) - len(results.todo), len(results.files)
    print(f"interrupted; {done} of {files} files are finished", file=sys.stderr)


def _fit_all(results: _Results, settings: FitSettings, workers: WorkerPool) -> None:
    """Fit what is left to do, with a bar that counts files and shows the time left."""
    from platform_daemon.analysis import Advanced, Finished, fit_files

    todo = results.todo
    shares = dict.fromkeys(todo, 0.0)
    with progress() as display:
        display.begin("fit", len(todo), "files")
        for event in fit_files(todo, settings, workers):
            shares[event.path] = event.share if isinstance(event, Advanced) else 1.0
            display.at(sum(shares.values()))
            if not isinstance(event, Advanced):
                outcome = event.report if isinstance(event, Finished) else event.error
                results.add(event.path, outcome, display.time_left)


def _end(results: _Results, json_file: Path | None) -> None:
    """Write the results; the exit code says whether something is amiss."""
    errors = results.errors
    if len(results.files) == 1 and errors:
        raise errors[0]
    write_json(json_file, results.content())
    if errors:
        raise typer.Exit(2 if all(isinstance(e, InputError) for e in errors) else 1)
    if not results.any_good:
        print(f"every frame was refused: {results.why_refused}", file=sys.stderr)
        raise typer.Exit(3)

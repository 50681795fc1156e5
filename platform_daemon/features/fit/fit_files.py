"""Fits of the files of one call of `fit`: where they are made, the lines that are printed, and the exit code."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import typer

from drivers.errors import InputError, PlatformError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import TableOptions
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.command_line.progress import progress
from platform_daemon.core.schemas.fits import FileError, FitBatch, FitReport

from .batch.executors import WorkerPool
from .batch.ledger import Ledger
from .batch.part import InputFile, count_frames
from .batch.run import Advanced, Finished, fit_files
from .fit_request import FitSettings
from .report import fit_line, fit_rows, fit_table_text

_SHOWN = 2  # files whose refusals are named at the end
_FEW_FRAMES = 16  # are fitted before other processes have started


def ledger_of(jsonl: Path | None, settings: FitSettings, *, resume: bool) -> AbstractContextManager[Ledger | None]:
    """The file of finished files, open; None: there is none."""
    return nullcontext() if jsonl is None else Ledger(jsonl, settings, resume=resume)


def batch_workers(
    files: Sequence[Path], settings: FitSettings, *, processes: int | None, dask: str | None
) -> AbstractContextManager[WorkerPool]:
    """Where to fit: the cluster, this process for few frames, else a process per core."""
    from .batch.dask_cluster import dask_cluster

    if dask is not None:
        return dask_cluster(dask, files[0])
    return workers_for(_FEW_FRAMES + 1 if _many_frames(files, settings) else 0, processes)


def workers_for(frames: int, processes: int | None = None) -> AbstractContextManager[WorkerPool]:
    """This process for few frames, else a process per core, or `processes` of them."""
    from .batch import executors

    count = processes or executors.cores()
    return executors.in_this_process() if count == 1 or frames <= _FEW_FRAMES else executors.processes(count)


def _many_frames(files: Sequence[Path], settings: FitSettings) -> bool:
    frames = 0
    for path in files[:_FEW_FRAMES]:
        try:
            frames += count_frames(InputFile(path), settings)
        except PlatformError:  # is reported when the file is fitted
            continue
        if frames > _FEW_FRAMES:
            return True
    return len(files) > _FEW_FRAMES


class FitResults:
    """The outcome of every file that has ended; of several files, a line of each is printed as it comes."""

    def __init__(self, files: list[Path], ledger: Ledger | None) -> None:
        self.files = list(dict.fromkeys(files))
        self._ledger = ledger
        self._ended: dict[Path, FitReport | PlatformError] = {}
        for path in self.files:
            report = None if ledger is None else ledger.finished(path)
            if report is not None:
                self._ended[path] = report
                self._print(path, "finished before")

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
        """That no frame has a fit, and what was wrong with the first excited frame of the first files, in one line."""
        reports = [(path, r.frames) for path, r in self._ended.items() if isinstance(r, FitReport) and r.frames]
        excited = [(path, found) for path, all_ in reports if (found := [f for f in all_ if not f.blank])]
        reasons = [
            f"{path}: frame {frames[0].frame}: {frames[0].reason}" if len(self.files) > 1
            else f"frame {frames[0].frame}: {frames[0].reason}"
            for path, frames in (excited or reports)[:_SHOWN]
        ]  # fmt: skip
        return f"{'every frame was refused' if excited else 'no frame was excited'}: {'; '.join(reasons)}"

    def add(self, path: Path, outcome: FitReport | PlatformError, time_left: str) -> None:
        """Keep and print the outcome of a file that has ended."""
        self._ended[path] = outcome
        if self._ledger is not None:
            self._ledger.add(path, outcome)
        self._print(path, time_left)

    def _print(self, path: Path, time_left: str) -> None:
        outcome = self._ended[path]
        if len(self.files) == 1:  # its table is printed once the result has been written
            return
        place = f"[{len(self._ended)}/{len(self.files)}] {path}"
        if isinstance(outcome, PlatformError):
            print(f"{place}: error: {outcome}", file=sys.stderr, flush=True)
        else:
            print(f"{place}: {fit_line(outcome)} ({time_left})", flush=True)

    def report(self, where: TableOptions) -> None:
        """Write the results of the files that have ended; print the table of an only file.  Raises StorageError."""
        content = self.content()
        write_json(where.json_file, content)
        if content is not None:
            files = content.files if isinstance(content, FitBatch) else (content,)
            write_csv(where.csv_file, (row for each in files if isinstance(each, FitReport) for row in fit_rows(each)))
        if len(self.files) == 1 and isinstance(content, FitReport):
            print(fit_table_text(content), flush=True)

    def content(self) -> FitReport | FitBatch | None:
        """For --json: the report of the one file, or all of them; None if no file has ended."""
        if not self._ended:
            return None
        entries = tuple(_entry(path, self._ended[path]) for path in self.files if path in self._ended)
        if len(self.files) == 1 and isinstance(entries[0], FitReport):
            return entries[0]
        return FitBatch(files=entries, unfinished=tuple(map(str, self.todo)) or None)


def _entry(path: Path, outcome: FitReport | PlatformError) -> FitReport | FileError:
    from .batch.ledger import error_summary

    if isinstance(outcome, PlatformError):
        return FileError(file=str(path), error=error_summary(outcome))
    return outcome


def report_interrupt(results: FitResults, where: TableOptions) -> None:
    """Write the files that have ended and name those that have not; where none has ended, nothing is written."""
    results.report(where)
    done, files = len(results.files) - len(results.todo), len(results.files)
    print(f"interrupted; {done} of {files} files are finished", file=sys.stderr)


def fit_all(results: FitResults, settings: FitSettings, workers: WorkerPool) -> None:
    """Fit what is left to do, with a bar that counts files and shows the time left."""
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


def report_results(results: FitResults, where: TableOptions) -> None:
    """Write the results.

    Raises the error of an only file; typer.Exit: 1 or 2 if files failed, 3 if no fit is good.
    """
    errors = results.errors
    if len(results.files) == 1 and errors:
        raise errors[0]
    results.report(where)
    if errors:
        raise typer.Exit(2 if all(isinstance(e, InputError) for e in errors) else 1)
    if not results.any_good:
        print(results.why_refused, file=sys.stderr)
        raise typer.Exit(3)

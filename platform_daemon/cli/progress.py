"""Progress on the terminal, on stderr, so that standard output holds results only."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from platform_daemon.engine import Job


def progress_bar() -> Progress:
    """A bar with count and time left, on stderr, so that standard output holds results only."""
    count = TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[unit]}")
    columns = (TextColumn("{task.description:<18}"), BarColumn(), count, TimeRemainingColumn())
    # What is printed meanwhile goes above the bar, unless it goes somewhere else.
    shown = sys.stdout.isatty()
    return Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=shown)


def watch(job: Job) -> None:
    """A progress bar until the job has ended; the operator's part is asked for above it."""
    with progress_bar() as bar:
        task = bar.add_task("waiting", total=job.total, unit=job.unit)
        while not job.ended.wait(timeout=0.1):
            now = job.progress()
            bar.update(task, completed=now.done, description=now.phase)
            if job.question is not None and not job.proceed.is_set():
                bar.stop()
                typer.prompt(f"{job.question}, then press Enter", default="", show_default=False, err=True)
                job.proceed.set()
                bar.start()

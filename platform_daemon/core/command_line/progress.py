"""Progress on the terminal, on stderr, so that standard output holds results only."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

from platform_daemon.core.schemas.control_characters import printable

from .shot_lines import ShotLines
from .terminal import for_rich, plain_text_only

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.core.jobs.jobs import Job


class _TimeLeft(ProgressColumn):
    """As the job says, else at the mean pace so far."""

    def render(self, task: Task) -> Text:
        """See rich.progress.ProgressColumn."""
        return Text(_time_left(task))


def _time_left(task: Task) -> str:
    if task.fields["left"] is not None:
        return str(task.fields["left"])
    if not task.completed or not task.total or task.elapsed is None:
        return ""
    return f"{task.elapsed * (task.total - task.completed) / task.completed:.0f} s left"


class ProgressDisplay:
    """One bar with count and time left, for one piece of work after the other."""

    def __init__(self, bar: Progress) -> None:
        self._bar = bar
        bar.add_task("waiting", total=1.0, unit="", curve="", left=None)
        (self._task,) = bar.tasks

    @property
    def time_left(self) -> str:
        """In words; empty: not known yet."""
        return _time_left(self._task)

    def begin(self, what: str, total: float, unit: str) -> None:
        """A new piece of work, from nothing."""
        self._bar.reset(self._task.id, description=what, total=total, unit=unit, curve="", left=None)

    def at(self, done: float, what: str | None = None) -> None:
        """So much is done; the bar never falls."""
        self._bar.update(self._task.id, completed=max(done, self._task.completed), description=what)

    def tell(self, what: str, share: float) -> None:
        """So much of a diagnosis is done, 0 to 1."""
        if self._task.fields["unit"] != "%":
            self.begin(what, 100.0, "%")
        self.at(100.0 * share, what)

    def say(self, text: str) -> None:
        """A line above the bar."""
        self._bar.console.print(printable(text), markup=False, highlight=False, soft_wrap=True)

    def ask(self, question: str) -> str:
        """The operator's answer; the bar is out of the way."""
        self._bar.stop()
        answer = typer.prompt(question, default="", show_default=False, err=True)
        self._bar.start()
        return str(answer)

    def watch(self, job: Job) -> None:
        """Show a job until it has ended, with a line for each shot; its questions are put to the operator.

        Any exception cancels the job before the display is taken away: on a terminal that is halted (Ctrl-S) the
        display blocks, and power would stay on meanwhile.
        """
        try:
            self._watch(job)
        except BaseException:
            job.request_cancel()
            raise

    def _watch(self, job: Job) -> None:
        self.begin("waiting", job.total, job.unit)
        lines = ShotLines(job)
        while not job.ended.wait(timeout=0.1):
            now = job.progress()
            left = "" if now.time_left_s is None else f"{now.time_left_s:.0f} s left"
            self._bar.update(self._task.id, left=left)
            self.at(now.done, now.phase)
            self._show(lines)
            if job.question is not None and not job.proceed.is_set():
                self.ask(f"{job.question}, then press Enter")
                job.proceed.set()
        self._show(lines)

    def _show(self, lines: ShotLines) -> None:
        for line in lines.new():
            self.say(line)
        self._bar.update(self._task.id, curve=lines.curve())


@contextmanager
def progress() -> Iterator[ProgressDisplay]:
    """A display that goes away when the work is done."""
    count = TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[unit]}")
    curve = TextColumn("{task.fields[curve]}")
    columns = (TextColumn("{task.description:<18}"), BarColumn(), count, _TimeLeft(), curve)
    # What is printed meanwhile goes above the bar, unless it goes somewhere else.
    shown = sys.stdout.isatty()
    console = Console(file=for_rich(sys.stderr))
    with Progress(*columns, console=console, transient=True, redirect_stdout=shown) as bar, plain_text_only():
        yield ProgressDisplay(bar)


def interrupted_while(engine: Engine, job: Job) -> bool:
    """Show the job until it has ended; True if Ctrl-C ended it, with outputs off and its shots put together."""
    try:
        with progress() as display:
            display.watch(job)
    except KeyboardInterrupt:
        engine.outputs_off()
        job.ended.wait(timeout=60)
        return True
    return False


def prepare_fit() -> None:
    """Before the first shot: kernels that are compiled or loaded meanwhile would lengthen the time between shots."""
    from platform_daemon.estimation.compilation import warm_up

    compile_fit()
    with Console(file=for_rich(sys.stderr)).status("preparing the fit (some seconds)"):
        warm_up()


def compile_fit() -> None:
    """Before a fit: compile what is not in numba's cache, and say so on stderr with the time that passes."""
    from platform_daemon.estimation.compilation import COMPILING, is_compiled, warm_up

    if is_compiled():
        return
    console = Console(file=for_rich(sys.stderr))
    if console.is_terminal:
        with Progress(TextColumn("{task.description}"), TimeElapsedColumn(), console=console) as shown:
            shown.add_task(COMPILING, total=None)
            warm_up()
    else:
        print(COMPILING, file=sys.stderr, flush=True)
        print(f"compiled in {warm_up():.0f} s", file=sys.stderr, flush=True)

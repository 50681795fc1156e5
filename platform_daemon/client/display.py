"""The progress of a job while it is waited for: a bar on the terminal, or a cell of a notebook with the last fit."""

from __future__ import annotations

import html
import sys
from typing import Any, Protocol

from platform_daemon.core.schemas.jobs import Job


class Display(Protocol):
    """Shows a job."""

    def at(self, view: Job[Any, Any]) -> None:
        """The job as it is now."""

    def close(self) -> None:
        """The job is not waited for any longer."""


class Hidden:
    """Shows nothing."""

    def at(self, view: Job[Any, Any]) -> None:
        """See Display."""

    def close(self) -> None:
        """See Display."""


class TerminalBar:
    """A bar on stderr, which never falls."""

    def __init__(self, job: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        columns = (TextColumn("{task.description:<18}"), BarColumn(), TextColumn("{task.fields[count]}"))
        self._bar = Progress(*columns, console=Console(stderr=True))
        self._task = self._bar.add_task(job, total=1.0, count="")
        self._bar.start()
        self._share = 0.0

    def at(self, view: Job[Any, Any]) -> None:
        """See Display."""
        self._share = max(self._share, view.progress.fraction)
        self._bar.update(self._task, completed=self._share, description=view.progress.phase, count=count_of(view))

    def close(self) -> None:
        """See Display."""
        self._bar.stop()


class NotebookCell:
    """HTML below the cell, which is replaced as the job goes on."""

    def __init__(self, job: str) -> None:
        from IPython.display import HTML, display

        self._html, self._job, self._share = HTML, job, 0.0
        self._handle: Any = display(HTML(self._text(0.0, "waiting", "")), display_id=True)

    def at(self, view: Job[Any, Any]) -> None:
        """See Display."""
        self._share = max(self._share, view.progress.fraction)
        text = self._text(self._share, view.progress.phase, count_of(view))
        self._handle.update(self._html(text + last_fit(view)))

    def close(self) -> None:
        """See Display."""

    def _text(self, share: float, phase: str, count: str) -> str:
        bar = f'<progress max="1" value="{share:.3f}" style="width: 20em"></progress>'
        return f"{html.escape(self._job)}<br>{bar} {html.escape(count)}, {html.escape(phase)}"


def display_of(job: str, *, shows: bool) -> Display:
    """What shows a job of that id here; shows: False, nothing does."""
    if not shows:
        return Hidden()
    return NotebookCell(job) if in_notebook() else TerminalBar(job)


def in_notebook() -> bool:
    """Whether this runs in a kernel of Jupyter."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def asks_to_stop(job: str) -> bool:
    """After Ctrl-C: does the user want the job stopped?

    A second Ctrl-C, or no terminal to ask on, leaves it running.
    """
    if not (in_notebook() or sys.stdin.isatty()):
        print(f"{job} goes on", file=sys.stderr)
        return False
    try:
        return input(f"\nStop {job}? Otherwise it goes on. [y/N] ").strip().lower() in ("y", "yes")
    except (EOFError, KeyboardInterrupt):
        return False


def count_of(view: Job[Any, Any]) -> str:
    """As `3/20 shots, 12 s left`."""
    now = view.progress
    left = "" if now.time_left_s is None or view.state.final else f", {now.time_left_s:.0f} s left"
    return f"{now.done:g}/{now.total:g} {now.unit}{left}"


def last_fit(view: Job[Any, Any]) -> str:
    """The parameters of the last good frame of a result that has fits, as a table in HTML; empty: there is none."""
    fit = getattr(view.result, "fit", None)
    frames = getattr(fit, "good_frames", None) or getattr(view.result, "good_frames", ())
    if not frames:
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{each.value:.8g}</td><td>{'' if each.std is None else f'{each.std:.2g}'}"
        "</td></tr>"
        for name, each in frames[-1].parameters.items()
    )
    return f"<table><tr><th>last fit</th><th>value</th><th>std</th></tr>{rows}</table>"

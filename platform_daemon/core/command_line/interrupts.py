"""Ctrl-C and SIGTERM of the commands: none is lost, and nothing disturbs the way out."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import sys
import termios
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

INTERRUPTED = 130
"""Exit code of a command that was interrupted."""

_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
_AGAIN_S = 0.02
"""How much later an interrupt that was lost comes again: callbacks of weak references end in microseconds."""


def heed_one_interrupt() -> None:
    """The next Ctrl-C, SIGTERM, SIGQUIT or closed terminal raises KeyboardInterrupt; those after it are ignored, also
    if a key is held down.

    The first one makes the command switch outputs off and close its files: a second one would cut that short.
    """
    for number in _ENDING:  # also where a shell has made background jobs ignore SIGINT
        # `nohup` has said that a closed terminal is nothing to it.
        if number != signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _first)


def _first(number: int, frame: FrameType | None) -> None:
    for each in _ENDING:
        signal.signal(each, signal.SIG_IGN)
    if number == signal.SIGHUP:
        _let_go_of_a_closed_terminal()
    raise KeyboardInterrupt


def _let_go_of_a_closed_terminal() -> None:
    """What is still said on the way out is lost there; it must not end the way out."""
    for stream in range(3):
        try:
            termios.tcgetattr(stream)
        except termios.error as error:
            if error.args[0] == errno.EIO:
                nowhere = os.open(os.devnull, os.O_RDWR)
                os.dup2(nowhere, stream)
                os.close(nowhere)


@contextmanager
def no_interrupt_lost() -> Iterator[None]:
    """An interrupt that strikes where Python lets no exception out comes again shortly after.

    A signal handler runs between any two lines, those of finalizers and of callbacks included; what is raised there is
    printed and forgotten, or turned into some other error.  The HDF5 library has many callbacks of weak references: a
    fit of many files missed one Ctrl-C in fourteen.
    """
    lost = False
    report = sys.unraisablehook

    def take(what: sys.UnraisableHookArgs) -> None:
        nonlocal lost
        if what.exc_type is KeyboardInterrupt:
            lost = True
            signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
        else:
            report(what)

    def again(number: int, frame: FrameType | None) -> None:
        nonlocal lost
        lost = False
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, again)
    sys.unraisablehook = take
    try:
        yield
    except Exception:
        if lost:
            raise KeyboardInterrupt from None
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        sys.unraisablehook = report


def end_at_once() -> NoReturn:
    """End an interrupted command that holds nothing, whatever its threads and processes are at.

    Threads that compile or fit cannot be stopped. A pool of processes that are ended while work is waiting may never
    come to its own end (Python 3.11: its thread stumbles over work that was cancelled).
    """
    import multiprocessing  # here, because the help of a command does not need it
    from multiprocessing import util

    with contextlib.suppress(OSError):  # the reader of the pipe has ended
        sys.stdout.flush()
        sys.stderr.flush()
    for child in multiprocessing.active_children():
        child.kill()
    # As at any other exit; else Python complains of semaphores that were not given back.
    util._run_finalizers(0)  # type: ignore[attr-defined]  # noqa: SLF001  (atexit does not run here)
    os._exit(INTERRUPTED)

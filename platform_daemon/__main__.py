"""Entry point of the command, also as `python -m platform_daemon`: Ctrl-C is heeded from the first import on."""

from __future__ import annotations

import gc
import os
import sys

_INTERRUPTED = 130  # as in core/command_line/interrupts.py, whose import an interrupt may strike
SELDOM = (20_000, 20, 20)
"""Thresholds of the search for garbage.  What a command imports all stays: with Python's own (700, 10, 10) the search
takes up to a sixth of a command."""


def main() -> None:
    """See `platform-daemon --help`."""
    gc.set_threshold(*SELDOM)
    try:
        _have_standard_streams()
        from .core.command_line.interrupts import no_interrupt_lost

        with no_interrupt_lost():
            from .cli.main import main as run
        run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(_INTERRUPTED)


def _have_standard_streams() -> None:
    """A socket that gets the number of one that is closed (`<&-`) would be taken for it, by every child, too."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # it gets the lowest number that is free
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, "r" if number == 0 else "w", encoding="utf-8", closefd=False))  # noqa: SIM115


if __name__ == "__main__":
    main()

"""Entry point of the command, also as `python -m platform_daemon`: Ctrl-C is heeded from the first import on."""

from __future__ import annotations

import os
import sys

from platform_daemon.cli.interrupts import INTERRUPTED, no_interrupt_lost


def main() -> None:
    """See `platform-daemon --help`."""
    _have_standard_streams()
    try:
        with no_interrupt_lost():
            from platform_daemon.cli.main import main as run
        run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)


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

"""Entry point of the command, also as `python -m platform_daemon`: Ctrl-C is heeded from the first import on."""

from __future__ import annotations

import sys

from platform_daemon.cli.interrupts import INTERRUPTED, no_interrupt_lost


def main() -> None:
    """See `platform-daemon --help`."""
    try:
        with no_interrupt_lost():
            from platform_daemon.cli.main import main as run
        run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()

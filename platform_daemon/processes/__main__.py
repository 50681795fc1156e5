"""`python -m platform_daemon.processes hardware|web|stop OPTIONS [SOCKETS]`: one process of the daemon."""

import gc
import sys

if __name__ == "__main__":  # a worker process imports this file too
    # What a start imports all stays: looking through it for garbage again and again takes a sixth of the start.
    gc.disable()  # until it has started, see ParentLink.report

    from .process import main

    sys.exit(main(sys.argv[1], sys.argv[2], tuple(map(int, sys.argv[3:]))))
